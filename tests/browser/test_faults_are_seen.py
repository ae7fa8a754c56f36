"""The eyes of these tests see what they are there to see, and nothing where there is nothing."""

import base64

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output

from .lab import THEMES, WIDGET_WORDS, WIDTHS

KERNEL = {"name": "python3", "display_name": "Python 3 (ipykernel)", "language": "python"}

FAULTY = [
    new_markdown_cell(
        "# Faults\n\n$$ a formula that never ends\n\n[nowhere](nowhere.ipynb) and [no part](#No-such-part)"
    ),
    new_markdown_cell("$\\frac{1}{2$ never closes."),
    new_markdown_cell("$\\left( x$ is wrong, and $\\nosuchsign$ unknown."),
    new_code_cell("from IPython.display import HTML, Javascript, display"),
    new_code_cell("HTML('<div style=\"width: 3000px\">wide</div>')"),
    new_code_cell("HTML('<img src=\"data:image/png;base64,AAAA\">')"),
    new_code_cell('HTML(\'<img alt="from elsewhere" src="http://elsewhere.invalid/a.png">\')'),
    new_code_cell("Javascript('console.error(\"the script complains\")')"),
    new_code_cell("import sys\nprint('careful', file=sys.stderr)\nprint('long ' * 60)"),
    new_code_cell("text = '" + "long " * 40 + "'"),
    new_code_cell("1 / 0"),
    new_code_cell("print('never run')"),
]

# Its circle is larger than the paper, which is no fault: a drawing is cut off at its edge.
PICTURE = (
    "<svg xmlns='http://www.w3.org/2000/svg' role='img' aria-label='a dot' width='90' height='90'>"
    "<circle cx='45' cy='45' r='400'/></svg>"
)

SOUND = [
    new_markdown_cell(
        "# Sound\n\n$v = r + \\gamma v'$ costs `$5`; see [below](#Sound) and [the start](00_start_here.ipynb)."
    ),
    new_markdown_cell(
        "| a | b |\n|---|---|\n| 1 | $$\\sum_s v(s)$$ |\n\n<details><summary>more</summary>\n\n$x$\n\n</details>"
    ),
    new_code_cell(
        "import ipywidgets as widgets\n\n"
        "slider = widgets.IntSlider(description='sweeps')\n"
        f'drawing = widgets.HTML("{PICTURE}")\n'
        "widgets.VBox([slider, widgets.HBox([widgets.Button(description='step')]), drawing])"
    ),
    new_code_cell("print('a table', 'of two')"),
]


WIDGET = {"application/vnd.jupyter.widget-view+json": {"model_id": "gone", "version_major": 2, "version_minor": 0}}


def stored(**data):
    """A cell as it lies in the file after a run: a widget, and what its author put beside it."""
    bundle = {name.replace("_", "/"): value for name, value in data.items()}
    return new_code_cell("widget", outputs=[new_output("display_data", data=WIDGET | bundle)])


@pytest.fixture
def open_page(lab):
    def open_page(name, cells, kernel=KERNEL, patience=20):
        notebook = new_notebook(cells=cells, metadata={"kernelspec": kernel})
        nbformat.write(notebook, lab.server.folder / name)
        return lab.open(name, patience)

    return open_page


def test_faults_are_seen(open_page):
    with open_page("faulty.ipynb", FAULTY, patience=2) as notebook:
        notebook.run_all()
        look, wide, cramped = notebook.look(), notebook.too_wide(), notebook.cramped()
        complaints = "\n".join(notebook.complaints)
    cells = look["cells"]
    assert [cell["count"] for cell in cells] == [None, None, None, 1, 2, 3, 4, 5, 6, 7, 8, None]
    assert [cell["index"] for cell in cells if cell["errors"]] == [10]
    assert cells[10]["errors"] == ["ZeroDivisionError: division by zero"]
    assert [cell["index"] for cell in cells if cell["warnings"]] == [8]
    assert [(image["cell"], image["alt"], image["width"]) for image in look["images"]] == [
        (5, "", 0),
        (6, "from elsewhere", 0),
    ]
    assert look["badFormulas"] == [
        "$$ a formula that never ends",
        "$\\frac{1}{2$ never closes.",
        "Extra \\left or missing \\right",
        "unknown: \\nosuchsign",
    ]
    assert look["links"] == {"files": ["/files/nowhere.ipynb"], "dead": ["#No-such-part"]}
    assert [fault.split(":")[0] for fault in wide] == ["cell 4"]
    assert [fault.split(":")[0] for fault in cramped] == ["cell 8", "cell 9"]
    assert "the script complains" in complaints
    assert "asks for http://elsewhere.invalid/a.png" in complaints


def test_nothing_is_seen_where_nothing_is(open_page):
    with open_page("sound.ipynb", SOUND) as notebook:
        notebook.run_all()
        look = notebook.look()
        assert [cell["count"] for cell in look["cells"]] == [None, None, 1, 2]
        assert [cell["pictures"] for cell in look["cells"]] == [0, 0, 1, 0]
        assert look["formulas"] == 3
        assert look["badFormulas"] == []
        assert look["links"] == {"files": ["/files/00_start_here.ipynb"], "dead": []}
        for theme in THEMES:
            for width in WIDTHS:
                notebook.dress(theme, width)
                assert notebook.too_wide() == []
        assert notebook.complaints == []


def test_stored_widget_needs_an_image(open_page):
    """JupyterLab cleans what it does not trust: a drawing in HTML vanishes, the same drawing as an image stays."""
    source = base64.b64encode(PICTURE.encode()).decode()
    cells = [
        stored(text_plain="VBox(children=())"),
        stored(text_plain="A dot", text_html=PICTURE),
        stored(text_plain="A dot", text_html=f'<img alt="a dot" src="data:image/svg+xml;base64,{source}">'),
    ]
    with open_page("widgets.ipynb", cells) as notebook:
        seen = notebook.look()["cells"]
    assert [cell["trusted"] for cell in seen] == [False, False, False]
    assert [bool(WIDGET_WORDS.search(cell["text"])) for cell in seen] == [True, False, False]
    assert [cell["pictures"] for cell in seen] == [0, 0, 1]


def test_endless_cell_is_named(open_page):
    endless = [new_code_cell("1 + 1"), new_code_cell("while True:\n    pass")]
    with open_page("endless.ipynb", endless) as notebook, pytest.raises(RuntimeError, match="after 2 s, in cell 1"):
        notebook.run_all(limit=2)


def test_dead_kernel_is_seen(open_page):
    deadly = [new_code_cell("import os\n\nos._exit(1)")]
    with open_page("deadly.ipynb", deadly) as notebook, pytest.raises(RuntimeError, match="appears to have died"):
        notebook.run_all()


def test_missing_kernel_is_seen(open_page):
    nobody = {"name": "nobody", "display_name": "Nobody", "language": "python"}
    with pytest.raises(RuntimeError, match="Select kernel for"), open_page("kernel.ipynb", SOUND, nobody):
        pass

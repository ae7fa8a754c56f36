"""Feedback pages that are safe to open: what a learner has written in them is read, and never run."""

from nbconvert.exporters import HTMLExporter

# The page's formulas are set by MathJax, which reads its settings with `eval`; nothing else may run or be loaded.
_MATHJAX = "https://cdnjs.cloudflare.com/ajax/libs/mathjax/2.7.7/"
_POLICY = (
    f"default-src 'none'; script-src {_MATHJAX} 'unsafe-eval'; font-src {_MATHJAX}; "
    f"style-src 'unsafe-inline' {_MATHJAX}; img-src data:; base-uri 'none'; form-action 'none'"
)


class FeedbackPage(HTMLExporter):
    """nbconvert's page with a content security policy: https://developer.mozilla.org/docs/Web/HTTP/Guides/CSP."""

    def from_notebook_node(self, nb, resources=None, **kw):
        """The page of a notebook, and its resources."""
        page, resources = super().from_notebook_node(nb, resources, **kw)
        before, head, after = page.partition("<head>")
        if not head:
            raise ValueError("nbconvert made a page without a head, where the policy would stand")
        return f'{before}{head}\n<meta http-equiv="Content-Security-Policy" content="{_POLICY}">{after}', resources

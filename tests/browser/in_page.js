// What the tests and the screenshots ask of a notebook that is open in JupyterLab. Runs inside the page.
window.course = (() => {
  let panel = null; // the notebook that is open
  const cells = () => panel.content.widgets;
  const scroller = () => panel.node.querySelector(".jp-WindowedPanel-outer");
  const all = (node, selector) => [...node.querySelectorAll(selector)];
  const pause = (seconds) => new Promise((done) => setTimeout(done, seconds * 1000));
  const short = (text) => text.replace(/\s+/g, " ").trim().slice(0, 120);
  const SHOWN = ".jp-OutputArea-output, .jp-RenderedMarkdown";
  const PRINTS = '.jp-RenderedText:is([data-mime-type$="stdout"], [data-mime-type="text/plain"]) pre';

  async function until(test, limit) {
    const end = Date.now() + limit * 1000;
    while (Date.now() < end) {
      const answer = test();
      if (answer) return answer;
      await pause(0.05);
    }
    return null;
  }

  async function open(path) {
    panel = await window.jupyterapp.commands.execute("docmanager:open", { path });
    await panel.context.ready;
    await panel.revealed;
  }

  async function close() {
    for (const answer of all(document, ".jp-Dialog .jp-mod-reject, .jp-Dialog .jp-mod-accept")) answer.click();
    if (!panel) return;
    // A kernel that has just died is being started again, and cannot be ended meanwhile.
    const end = () => panel.sessionContext.shutdown();
    await end().catch(() => pause(3).then(end));
    panel.dispose(); // without asking whether to save
    panel = null;
  }

  // JupyterLab asks when it does not know which kernel is wanted, and tells when one has died.
  function dialog() {
    const box = document.querySelector(".jp-Dialog-content");
    return box && `JupyterLab says: ${short(box.innerText)}`;
  }

  async function waitForKernel(limit) {
    const status = () => panel?.sessionContext?.session?.kernel?.status;
    const answer = await until(() => (status() === "idle" ? "idle" : dialog()), limit);
    return answer || `no kernel after ${limit} s, only ${status() || "silence"}`;
  }

  async function runAll(limit) {
    const commands = window.jupyterapp.commands;
    // Cleared first, so that nothing stored can be taken for something printed now.
    await commands.execute("notebook:clear-all-cell-outputs");
    let done = null;
    commands.execute("notebook:run-all-cells").then(() => (done = "done"));
    return (await until(() => dialog() || done, limit)) || `still running after ${limit} s, in ${runningCell()}`;
  }

  function runningCell() {
    const waits = (cell) => cell.node.querySelector(".jp-InputPrompt")?.innerText.includes("*");
    return `cell ${cells().findIndex(waits)}`;
  }

  async function settle(limit) {
    await document.fonts.ready;
    const loaded = () => all(panel.node, "img").every((image) => image.complete);
    await until(() => loaded() && rawFormulas().length + missingFormulas().length === 0, limit);
    await twoFrames();
  }

  // Layout follows a change of size or theme one frame later, JupyterLab's own a frame after that.
  function twoFrames() {
    return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 100))));
  }

  async function setTheme(name) {
    if (document.body.dataset.jpThemeName !== name) {
      await window.jupyterapp.commands.execute("apputils:change-theme", { theme: name });
      await until(() => document.body.dataset.jpThemeName === name, 20);
    }
    await twoFrames();
  }

  function lookAtCell(cell, index) {
    const model = cell.model;
    const outputs = model.type === "code" ? model.outputs.toJSON() : [];
    return {
      index,
      type: model.type,
      trusted: model.trusted,
      count: model.executionCount ?? null,
      errors: outputs.filter((one) => one.output_type === "error").map((one) => `${one.ename}: ${one.evalue}`),
      warnings: outputs.filter((one) => one.name === "stderr").map((one) => short([one.text].flat().join(""))),
      text: all(cell.node, SHOWN).map((area) => area.innerText).join("\n"),
      pictures: all(cell.node, SHOWN).flatMap((area) => all(area, "img, svg")).filter(isDrawn).length,
    };
  }

  function isDrawn(picture) {
    const box = picture.getBoundingClientRect();
    return box.width > 1 && box.height > 1 && picture.naturalWidth !== 0;
  }

  function images() {
    return cells().flatMap((cell, index) =>
      all(cell.node, ".jp-OutputArea-output img, .jp-RenderedMarkdown img").map((image) => ({
        cell: index,
        alt: image.alt.trim() === "Image" ? "" : image.alt.trim(), // JupyterLab's word where there is none
        width: image.naturalWidth,
        source: image.src.slice(0, 80),
      })),
    );
  }

  // Formulas that were left as they were typed: dollars and backslashes outside of code.
  function rawFormulas() {
    const typed = /\$\$|\\\(|\\\[|\\[a-zA-Z]{2,}|\$[^$\s][^$]*\$/;
    const found = [];
    for (const area of all(panel.node, ".jp-RenderedHTMLCommon, .jp-RenderedLatex")) {
      const words = document.createTreeWalker(area, NodeFilter.SHOW_TEXT);
      while (words.nextNode()) {
        const word = words.currentNode;
        const quoted = word.parentElement.closest("code, pre, mjx-container, script, style");
        if (!quoted && typed.test(word.data)) found.push(short(word.data));
      }
    }
    return found;
  }

  // Cells whose source has a formula and whose rendering has none.
  function missingFormulas() {
    const code = /```[\s\S]*?```|`[^`\n]*`/g;
    const formula = /\$\$[\s\S]+?\$\$|(^|[^\\$])\$[^\s$]([^$\n]*[^\s$\\])?\$/;
    return cells()
      .filter((cell) => cell.model.type === "markdown")
      .filter((cell) => formula.test(cell.model.sharedModel.getSource().replace(code, "")))
      .filter((cell) => !cell.node.querySelector("mjx-container"))
      .map((cell) => short(cell.model.sharedModel.getSource()));
  }

  // MathJax says what is wrong with a formula, but a sign that it does not know it merely prints, in red.
  function wrongFormulas() {
    const wrong = all(panel.node, "mjx-merror").map((node) => short(node.dataset.mjxError || node.textContent));
    const texts = all(panel.node, "math mtext").filter((node) => !node.closest("merror"));
    const unknown = texts.map((node) => node.textContent).filter((text) => text.startsWith("\\"));
    return [...wrong, ...unknown.map((sign) => `unknown: ${short(sign)}`)];
  }

  // Links that stay in the course: files as JupyterLab would open them, places as headings on this page.
  function links() {
    const marks = new Set(all(panel.node, "[id], [data-jupyter-id]").flatMap((n) => [n.id, n.dataset.jupyterId]));
    const found = { files: [], dead: [] };
    for (const link of all(panel.node, ".jp-RenderedHTMLCommon a")) {
      const target = link.getAttribute("href");
      if (!target) found.dead.push(short(link.outerHTML));
      else if (target.startsWith("#")) marks.has(decodeURIComponent(target.slice(1))) || found.dead.push(target);
      else if (link.origin === location.origin) found.files.push(decodeURIComponent(link.pathname));
    }
    return found;
  }

  function look() {
    return {
      cells: cells().map(lookAtCell),
      images: images(),
      formulas: all(panel.node, "mjx-container").length,
      badFormulas: [...new Set([...rawFormulas(), ...missingFormulas(), ...wrongFormulas()])],
      links: links(),
    };
  }

  // Folded answers count as well.
  function openFolds() {
    const folded = all(panel.node, "details:not([open])");
    for (const fold of folded) fold.open = true;
    return folded;
  }

  function sticksOut(node, edge) {
    const invisible = node.closest("mjx-assistive-mml"); // for screen readers
    const insidePicture = node.parentElement.closest("svg");
    if (invisible || insidePicture) return 0;
    const over = node.getBoundingClientRect().right - edge;
    const scrolls = getComputedStyle(node).overflowX !== "visible" ? node.scrollWidth - node.clientWidth : 0;
    return Math.max(over, scrolls);
  }

  const innermost = (nodes) => nodes.find((node) => !nodes.some((other) => other !== node && node.contains(other)));

  // What makes an output or a text too wide, or nothing. The innermost node is the reason why those around it are wide.
  function culprit(area, cell) {
    const edge = Math.min(area.getBoundingClientRect().right, cell.getBoundingClientRect().right);
    const inside = all(area, "*");
    const wide = innermost([area, ...inside].filter((node) => sticksOut(node, edge) > 1));
    if (!wide) return null;
    // It may have pushed no further than into the margin of the area, which then scrolls by that margin.
    const margin = parseFloat(getComputedStyle(area).paddingRight);
    const pusher = wide === area && innermost(inside.filter((node) => sticksOut(node, edge - margin) > 1));
    const node = pusher || wide;
    const named = node.closest("mjx-container") || node;
    const over = Math.max(...[area, ...inside].map((one) => sticksOut(one, edge)));
    return `<${named.localName}> ${Math.round(over)} px too wide: ${short(named.textContent)}`;
  }

  function tooWide() {
    const folded = openFolds(); // what is folded away has no width
    const found = [];
    cells().forEach((cell, index) => {
      for (const area of all(cell.node, SHOWN)) {
        const fault = culprit(area, cell.node);
        if (fault) found.push(`cell ${index}: ${fault}`);
      }
    });
    const view = scroller();
    if (view.scrollWidth > view.clientWidth + 1) found.push("the notebook as a whole");
    for (const fold of folded) fold.open = false;
    return found;
  }

  // Printed lines that had to be broken, which spoils printed tables; and code that has to be scrolled.
  function cramped() {
    const found = [];
    cells().forEach((cell, index) => {
      for (const print of all(cell.node, PRINTS)) {
        const lines = print.textContent.replace(/\n$/, "").split("\n").length;
        const seen = Math.round(print.getBoundingClientRect().height / parseFloat(getComputedStyle(print).lineHeight));
        if (seen > lines) found.push(`cell ${index}: ${lines} printed lines became ${seen}`);
      }
      for (const editor of all(cell.node, ".cm-scroller")) {
        const over = editor.scrollWidth - editor.clientWidth;
        if (cell.model.type === "code" && over > 1) found.push(`cell ${index}: code ${over} px too wide`);
      }
    });
    return found;
  }

  // Top and bottom of every page, counted from the top of the notebook.
  function cutIntoPages(height) {
    const view = scroller();
    const origin = view.getBoundingClientRect().top - view.scrollTop;
    const pages = [];
    for (const cell of cells()) {
      const box = cell.node.getBoundingClientRect();
      let top = box.top - origin;
      const bottom = box.bottom - origin;
      const last = pages[pages.length - 1];
      if (last && bottom - last.top <= height) last.bottom = bottom;
      else for (; top < bottom; top += height) pages.push({ top, bottom: Math.min(bottom, top + height) });
    }
    return pages;
  }

  async function scrollTo({ top, bottom }) {
    const view = scroller();
    view.scrollTop = top;
    await twoFrames();
    const box = view.getBoundingClientRect();
    return { x: box.left, y: box.top + top - view.scrollTop, width: box.width, height: bottom - top };
  }

  return {
    open, close, waitForKernel, runAll, settle, setTheme,
    look, tooWide, cramped, openFolds, cutIntoPages, scrollTo,
  };
})();

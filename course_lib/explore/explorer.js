// Shows an explorer's view and sends what is done to it. What the learner does is queued here, not in the kernel:
// one message is under way at a time, and of several moves of one slider in a row only the last is sent.

function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

// JupyterLab would take arrows and letters for commands of its own; it asks the element that has the focus first.
const KEYS_ARE_OURS = { "data-lm-suppress-shortcuts": "true" };

const PATIENCE = 5000; // milliseconds without an answer, after which something is said
const NO_ANSWER =
  "No answer from Python. If another cell is running, wait for it; if the kernel was restarted, run this cell again.";

function makeQueue(model, root, sayLate) {
  const waiting = [];
  let sent = 0;
  let underWay = null;
  let late = false;
  // Else a control that was moved is ahead of what the kernel says about it.
  const idle = () => underWay === null && !waiting.length;

  function giveUp(id) {
    if (underWay !== id) return;
    late = true;
    waiting.length = 0; // nobody wants to see them all happen at once, later
    sayLate();
  }

  function next() {
    if (underWay === null && waiting.length) {
      const id = `${root.dataset.ids}-${sent++}`;
      underWay = id;
      setTimeout(() => giveUp(id), PATIENCE);
      model.send({ id, do: waiting.shift() });
    }
    root.dataset.idle = idle();
  }
  return {
    add(what, ...rest) {
      if (late) return;
      const last = waiting[waiting.length - 1];
      if (what === "turn" && last && last[0] === what && last[1] === rest[0]) waiting.pop();
      waiting.push([what, ...rest]);
      next();
    },
    answered(id) {
      if (id !== underWay) return;
      underWay = null;
      late = false;
      next();
    },
    idle,
  };
}

// --- controls: each maker gives a node, and a function that shows the control as it now stands ------------------------

function slider(spec, queue) {
  const input = element("input", { type: "range", min: 0, step: 1, ...KEYS_ARE_OURS });
  const shown = element("span", { class: "ce-value", "aria-hidden": "true" }); // the input says it itself
  let texts = [];
  const say = () => {
    shown.textContent = texts[input.value];
    input.setAttribute("aria-valuetext", texts[input.value]);
  };
  input.addEventListener("input", () => {
    say();
    queue.add("turn", spec.name, Number(input.value));
  });
  const label = element("span", { class: "ce-name" });
  return {
    node: element("label", { class: "ce-slider" }, label, input, shown),
    show(control) {
      label.textContent = control.label;
      texts = control.texts;
      input.max = texts.length - 1;
      if (queue.idle()) input.value = control.at;
      say();
    },
  };
}

function choice(spec, queue) {
  const select = element("select", KEYS_ARE_OURS);
  select.addEventListener("change", () => queue.add("turn", spec.name, select.selectedIndex));
  const label = element("span", { class: "ce-name" });
  let texts = [];
  return {
    node: element("label", { class: "ce-choice" }, label, select),
    show(control) {
      label.textContent = control.label;
      if (JSON.stringify(texts) !== JSON.stringify(control.texts)) {
        texts = control.texts;
        select.replaceChildren(...texts.map((text) => element("option", {}, text)));
      }
      if (queue.idle()) select.selectedIndex = control.at;
    },
  };
}

function toggle(spec, queue) {
  const input = element("input", { type: "checkbox", ...KEYS_ARE_OURS });
  input.addEventListener("change", () => queue.add("turn", spec.name, Number(input.checked)));
  const label = element("span");
  return {
    node: element("label", { class: "ce-switch" }, input, label),
    show(control) {
      label.textContent = control.label;
      if (queue.idle()) input.checked = control.at === 1;
    },
  };
}

function button(spec, queue) {
  const node = element("button", { type: "button", class: "ce-button", ...KEYS_ARE_OURS });
  node.addEventListener("click", () => {
    if (node.getAttribute("aria-disabled") !== "true") queue.add("press", spec.name);
  });
  return {
    node,
    show(control) {
      node.textContent = control.label;
      node.setAttribute("aria-disabled", control.idle); // not `disabled`, which would take the focus away
    },
  };
}

const MAKERS = { slider, choice, switch: toggle, button };

// --- panels ----------------------------------------------------------------------------------------------------------

const KEYS = ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"];

function panel(spec, queue, ids) {
  const ours = spec.board ? KEYS_ARE_OURS : {};
  const picture = element("div", { class: spec.svg ? "ce-picture" : "ce-text", ...ours });
  const node = element("div", { class: "ce-panel", "data-panel": spec.name }, picture);
  const words = element("p", { id: `${ids}-${spec.name}-words`, hidden: "" }); // read out, not shown
  let drawn = null;
  if (spec.board) {
    picture.tabIndex = 0;
    picture.setAttribute("role", "application");
    picture.setAttribute("aria-label", spec.board);
    picture.setAttribute("aria-describedby", words.id);
    picture.classList.add("ce-board");
    picture.addEventListener("keydown", (event) => {
      if (!KEYS.includes(event.key) || event.altKey || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      if (!event.repeat || queue.idle()) queue.add("arrow", event.key); // a key held down does not queue up
    });
    picture.addEventListener("click", (event) => {
      // The picture may have been drawn anew between the button's press and its release.
      const cell = document.elementFromPoint(event.clientX, event.clientY)?.closest("[data-cell]");
      if (cell && picture.contains(cell)) queue.add("choose", Number(cell.dataset.cell));
    });
    node.append(element("p", { class: "ce-hint", "aria-hidden": "true" }, spec.board), words);
  } else if (spec.svg) picture.setAttribute("role", "img");
  return {
    node,
    show(view) {
      // Patterns are found by their ids in the whole page, and in a hidden notebook they fill nothing.
      const markup = view.svg.replace(/(\bid="|url\(#)/g, `$1${ids}-${view.name}-`) || view.html;
      if (markup !== drawn) picture.innerHTML = drawn = markup;
      if (view.board) words.textContent = view.words;
      else if (view.svg) picture.setAttribute("aria-label", view.words);
    },
  };
}

// Shows a list of things; what stays is not touched, since that would cost the focus.
function makeList(place, make, identity) {
  const made = new Map();
  return (specs) => {
    const names = specs.map((spec) => JSON.stringify(identity(spec)));
    for (const [name, one] of made) {
      if (names.includes(name)) continue;
      one.node.remove();
      made.delete(name);
    }
    specs.forEach((spec, i) => {
      if (!made.has(names[i])) made.set(names[i], make(spec));
      const one = made.get(names[i]);
      if (place.children[i] !== one.node) place.insertBefore(one.node, place.children[i] ?? null);
      one.show(spec);
    });
  };
}

function render({ model, el }) {
  const title = element("div", { class: "ce-title" });
  const controls = element("div", { class: "ce-controls" });
  const panels = element("div", { class: "ce-panels" });
  const message = element("p", { class: "ce-message", role: "status" });
  const bar = element("progress", { max: 1, "aria-label": "progress" });
  const root = element("div", { class: "course-explorer", role: "group", ...KEYS_ARE_OURS });
  const ids = `ce-${Math.random().toString(36).slice(2)}`; // no other explorer in the page has the same
  Object.assign(root.dataset, { ids, idle: true });
  root.append(title, controls, bar, message, panels);
  el.append(root);
  const queue = makeQueue(model, root, () => (message.textContent = NO_ANSWER));

  const showControls = makeList(controls, (spec) => MAKERS[spec.kind](spec, queue), (spec) => [spec.kind, spec.name]);
  const showPanels = makeList(
    panels,
    (spec) => panel(spec, queue, ids),
    (spec) => [spec.name, Boolean(spec.svg), spec.board],
  );
  const show = {
    title() {
      title.textContent = model.get("title");
      root.setAttribute("aria-label", model.get("title"));
    },
    controls: () => showControls(model.get("controls")),
    panels: () => showPanels(model.get("panels")),
    message() {
      if (message.textContent !== model.get("message")) message.textContent = model.get("message");
    },
    progress() {
      bar.hidden = model.get("progress") === null;
      bar.value = model.get("progress") ?? 0;
    },
    answered() {
      queue.answered(model.get("answered"));
      show.message();
      if (queue.idle()) showControls(model.get("controls"));
    },
  };
  for (const [trait, draw] of Object.entries(show)) {
    draw();
    model.on(`change:${trait}`, draw);
  }
  return () => {
    for (const [trait, draw] of Object.entries(show)) model.off(`change:${trait}`, draw);
  };
}

export default { render };

// Shows an explorer's view and sends what is done to it. What the learner does is queued here, not in the kernel:
// one message is under way at a time, and of several moves of one slider only the last is sent.

function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

// JupyterLab would take arrows and letters for commands of its own; it asks the element that has the focus first.
const KEYS_ARE_OURS = { "data-lm-suppress-shortcuts": "true" };

let views = 0;

function makeQueue(model, root) {
  const name = `${Date.now()}-${views++}`;
  const waiting = [];
  let sent = 0;
  let underWay = null;
  // Else a control that was moved is ahead of what the kernel says about it.
  const idle = () => underWay === null && !waiting.length;

  function next() {
    if (underWay === null && waiting.length) {
      underWay = `${name}-${sent++}`;
      model.send({ id: underWay, do: waiting.shift() });
    }
    root.dataset.idle = idle();
  }
  return {
    add(what, ...rest) {
      if (what === "turn") {
        const older = waiting.findIndex((entry) => entry[0] === what && entry[1] === rest[0]);
        if (older >= 0) waiting.splice(older, 1);
      }
      waiting.push([what, ...rest]);
      next();
    },
    answered(id) {
      if (id !== underWay) return;
      underWay = null;
      next();
    },
    idle,
  };
}

// --- controls: each maker gives a node, and a function that shows the control as it now stands ------------------------

function slider(spec, queue) {
  const input = element("input", { type: "range", min: 0, step: 1, ...KEYS_ARE_OURS });
  const shown = element("output");
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

function panel(spec, queue) {
  const picture = element("div", { class: spec.svg ? "ce-picture" : "ce-text" });
  const node = element("div", { class: "ce-panel", "data-panel": spec.name }, picture);
  const words = element("p", { id: `ce-${Date.now()}-${spec.name}`, hidden: "" }); // read out, not shown
  let drawn = null;
  if (spec.board) {
    picture.tabIndex = 0;
    picture.setAttribute("role", "application");
    picture.setAttribute(...Object.entries(KEYS_ARE_OURS)[0]);
    picture.setAttribute("aria-describedby", words.id);
    picture.classList.add("ce-board");
    picture.addEventListener("keydown", (event) => {
      if (!KEYS.includes(event.key) || event.altKey || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      queue.add("arrow", event.key);
    });
    picture.addEventListener("pointerdown", (event) => {
      const cell = event.target.closest("[data-cell]");
      if (cell) queue.add("choose", Number(cell.dataset.cell));
    });
    node.append(element("p", { class: "ce-hint" }, spec.board), words);
  } else if (spec.svg) picture.setAttribute("role", "img");
  return {
    node,
    show(view) {
      const markup = view.svg || view.html;
      if (markup !== drawn) picture.innerHTML = drawn = markup;
      if (view.board) {
        picture.setAttribute("aria-label", view.board);
        words.textContent = view.words;
      } else if (view.svg) picture.setAttribute("aria-label", view.words);
    },
  };
}

// Shows a list of things; makes them anew only where their names or kinds have changed, which would cost the focus.
function makeList(place, make, identity) {
  let made = [];
  let names = "";
  return (specs) => {
    const now = JSON.stringify(specs.map(identity));
    if (now !== names) {
      names = now;
      made = specs.map(make);
      place.replaceChildren(...made.map((one) => one.node));
    }
    specs.forEach((spec, i) => made[i].show(spec));
  };
}

function render({ model, el }) {
  const title = element("div", { class: "ce-title" });
  const controls = element("div", { class: "ce-controls" });
  const panels = element("div", { class: "ce-panels" });
  const message = element("p", { class: "ce-message", role: "status" });
  const bar = element("progress", { max: 1, "aria-label": "progress" });
  const root = element("div", { class: "course-explorer", role: "group", ...KEYS_ARE_OURS });
  root.dataset.idle = true;
  root.append(title, controls, bar, message, panels);
  el.append(root);
  const queue = makeQueue(model, root);

  const showControls = makeList(controls, (spec) => MAKERS[spec.kind](spec, queue), (spec) => [spec.kind, spec.name]);
  const showPanels = makeList(
    panels,
    (spec) => panel(spec, queue),
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

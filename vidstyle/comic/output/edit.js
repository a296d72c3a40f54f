// Drag balloons, change words, save the page file with these changes. vidstyle draws the final shapes from that
// file; this script only moves and stretches them.

const KEY = "[[page.panel.words]]";
const file = JSON.parse(document.getElementById("page-file").textContent);
const [head, ...rest] = file.split(KEY);
const entries = rest.map((text) => ({ text, words: JSON.parse(/^text = (.*)$/m.exec(text)[1]) }));
const groups = [...document.querySelectorAll("g[data-place]")];
const inCapitals = /^font = "comic"$/m.test(head);
const past = [];

/** Parse the numbers of an attribute; undefined if it is missing. */
const numbers = (text) => text?.split(" ").map(Number);

const bubbles = groups.map((group, number) => ({
  group,
  number,
  place: numbers(group.dataset.place),
  tip: numbers(group.dataset.tip),
  words: entries[number].words,
  shapes: [...group.querySelectorAll("polygon")].map((each) => [each, numbers(each.getAttribute("points").replaceAll(",", " "))]),
  texts: [...group.querySelectorAll("text > tspan")],
}));
bubbles.forEach((bubble) => Object.assign(bubble, { first: bubble.place, wordsBefore: bubble.words }));

/** Return the corners of a shape moved and stretched with its words; the tip of a tail stays. */
function outline(bubble, points) {
  const [left, top, right, bottom] = bubble.first;
  const [x, y, xx, yy] = bubble.place;
  const corners = [];
  for (let at = 0; at < points.length; at += 2) {
    const [across, down] = [(points[at] - left) / (right - left), (points[at + 1] - top) / (bottom - top)];
    corners.push([x + across * (xx - x), y + down * (yy - y)]);
  }
  if (!bubble.tip || bubble.group.matches(".cloud")) return corners;
  // The second corner is the tip of the tail, between its roots, which are recomputed on the side of the tip.
  corners.splice(1, 1);
  const { tip } = bubble;
  const [middle, half] = [[(x + xx) / 2, (y + yy) / 2], Math.hypot(points[0] - points[4], points[1] - points[5]) / 2];
  const way = Math.hypot(tip[0] - middle[0], tip[1] - middle[1]) || 1;
  const [dx, dy] = [(tip[0] - middle[0]) / way, (tip[1] - middle[1]) / way];
  const isRoot = ([px, py]) =>
    Math.abs((px - middle[0]) * dy - (py - middle[1]) * dx) <= half && (px - middle[0]) * dx + (py - middle[1]) * dy > 0;
  const start = corners.findIndex((each, at) => isRoot(each) && !isRoot(corners.at(at - 1)));
  if (start < 0) return corners;
  const turned = [...corners.slice(start), ...corners.slice(0, start)];
  const count = turned.findIndex((each) => !isRoot(each));
  return [turned[0], tip, ...turned.slice(Math.max(1, count - 1))];
}

function draw(bubble) {
  const around = bubble.shapes.at(-1);
  // The circles of a thought do not move.
  if (around) around[0].setAttribute("points", outline(bubble, around[1]).join(" "));
  const [text] = bubble.group.querySelectorAll("text");
  const size = Number(text.getAttribute("font-size"));
  const [left, top, right, bottom] = bubble.place;
  const lines = (inCapitals ? bubble.words.toUpperCase() : bubble.words).split("\n");
  const inset = bubble.first[0] - bubble.texts[0].getAttribute("x");
  const centred = bubble.group.matches(".balloon, .burst, .cloud, .whisper");
  text.replaceChildren(
    ...lines.map((line, number) => {
      const row = document.createElementNS("http://www.w3.org/2000/svg", "tspan");
      row.setAttribute("x", centred ? (left + right) / 2 : left - inset);
      if (centred) row.setAttribute("text-anchor", "middle");
      row.setAttribute("y", (top + bottom) / 2 + (1.2 * (number - (lines.length - 1) / 2) + 0.3) * size);
      for (const [, stressed, plain] of line.matchAll(/\*(\w(?:[^*]*\w)?)\*|([^*]+|\*)/g)) {
        const part = document.createElementNS(row.namespaceURI, "tspan");
        part.textContent = stressed ?? plain;
        if (stressed) part.setAttribute("font-weight", "bold");
        row.append(part);
      }
      return row;
    }),
  );
}

/** Change the words or the place of a bubble, with undo. */
function change(bubble, next) {
  past.push([bubble, { place: bubble.place, words: bubble.words }]);
  Object.assign(bubble, next);
  draw(bubble);
  undo.disabled = false;
}

/** Return the place around the same centre, stretched like the words. */
function stretched(bubble, words) {
  const extent = (text) => [Math.max(...text.split("\n").map((line) => line.length)), text.split("\n").length];
  const [[wide, high], [newWide, newHigh]] = [extent(bubble.wordsBefore), extent(words)];
  const [left, top, right, bottom] = bubble.place;
  const [x, y] = [(left + right) / 2, (top + bottom) / 2];
  const across = ((bubble.first[2] - bubble.first[0]) / 2) * (newWide / wide);
  const down = ((bubble.first[3] - bubble.first[1]) / 2) * (newHigh / high);
  return [x - across, y - down, x + across, y + down];
}

function edit(bubble) {
  const box = bubble.group.getBoundingClientRect();
  const input = Object.assign(document.createElement("textarea"), { className: "words", value: bubble.words });
  const size = Number(bubble.group.querySelector("text").getAttribute("font-size"));
  const scale = bubble.group.getScreenCTM().a;
  const font = getComputedStyle(bubble.group).fontFamily;
  Object.assign(input.style, {
    left: `${box.left + scrollX - 12}px`,
    top: `${box.top + scrollY - 6}px`,
    width: `${Math.max(box.width, 120) + 24}px`,
    height: `${Math.max(box.height, 1.2 * size * scale * bubble.words.split("\n").length) + 18}px`,
    font: `${size * scale}px/1.2 ${font}`,
  });
  input.setAttribute("aria-label", "Words");
  document.body.append(input);
  input.focus();
  input.select();
  input.addEventListener("keydown", (event) => {
    if (event.key === "Escape") input.value = bubble.words;
    if (event.key === "Escape" || (event.key === "Enter" && !event.shiftKey)) input.blur();
  });
  input.addEventListener("blur", () => {
    const words = input.value.split("\n").map((line) => line.trim()).filter(Boolean).join("\n");
    input.remove();
    if (words && words !== bubble.words) change(bubble, { words, place: stretched(bubble, words) });
    bubble.group.focus();
  });
}

/** Return a place moved by a distance, at most to the edge of its page. */
function within(group, place, by) {
  const { width, height } = group.ownerSVGElement.viewBox.baseVal;
  const [x, y] = [width, height].map((side, at) => Math.min(side - place[at + 2], Math.max(-place[at], by[at])));
  return [place[0] + x, place[1] + y, place[2] + x, place[3] + y];
}

function drag(bubble, event) {
  if (event.button !== 0) return;
  const { group } = bubble;
  const from = bubble.place;
  const scale = group.getScreenCTM().a;
  group.setPointerCapture(event.pointerId);
  group.classList.add("held");
  const shifted = (to) => {
    return within(group, from, [(to.clientX - event.clientX) / scale, (to.clientY - event.clientY) / scale]);
  };
  const move = (to) => {
    bubble.place = shifted(to);
    draw(bubble);
  };
  const drop = (to) => {
    group.removeEventListener("pointermove", move);
    group.classList.remove("held");
    bubble.place = from;
    if (Math.hypot(to.clientX - event.clientX, to.clientY - event.clientY) > 3) change(bubble, { place: shifted(to) });
    else draw(bubble);
  };
  group.addEventListener("pointermove", move);
  group.addEventListener("lostpointercapture", drop, { once: true });
}

const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function key(bubble, event) {
  if (event.target !== bubble.group) return;
  const step = STEPS[event.key];
  if (step) {
    const by = event.shiftKey ? 20 : 4;
    change(bubble, { place: within(bubble.group, bubble.place, step.map((each) => by * each)) });
  } else if (event.key === "Enter") edit(bubble);
  else return;
  event.preventDefault();
}

/** Return the edited page file; unchanged entries are copied byte for byte. */
function saved() {
  const texts = bubbles.map((bubble) => {
    const { text, words } = entries[bubble.number];
    const place = bubble.place.map((side) => Math.round(side * 100) / 100).join(", ");
    const other = bubble.words === words ? text : text.replace(/^text = .*$/m, () => `text = ${JSON.stringify(bubble.words)}`);
    return bubble.place === bubble.first ? other : other.replace(/^place = .*$/m, `place = [${place}]`);
  });
  return [head, ...texts].join(KEY);
}

function save() {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([saved()], { type: "application/toml" }));
  link.download = "comic.toml";
  link.click();
  URL.revokeObjectURL(link.href);
}

function button(text, press, name = "") {
  const made = Object.assign(document.createElement("button"), { type: "button", textContent: text, className: name });
  made.addEventListener("click", press);
  return made;
}

const undo = button("Undo", () => {
  const [bubble, before] = past.pop();
  Object.assign(bubble, before);
  draw(bubble);
  undo.disabled = !past.length;
});
undo.disabled = true;

if (bubbles.length) {
  for (const bubble of bubbles) {
    const { group } = bubble;
    group.tabIndex = 0;
    group.setAttribute("role", "button");
    group.setAttribute("aria-label", `${bubble.words.replaceAll("\n", " ")}. Enter changes the words, arrows move them.`);
    if (!group.matches(".band")) {
      group.classList.add("editable");
      group.addEventListener("pointerdown", (event) => drag(bubble, event));
      group.addEventListener("keydown", (event) => key(bubble, event));
    }
    group.addEventListener("dblclick", () => edit(bubble));
  }
  const bar = Object.assign(document.createElement("div"), { className: "bar" });
  bar.append("Drag a balloon, double-click its words", undo, button("Save comic.toml", save, "main"));
  document.body.append(bar);
}

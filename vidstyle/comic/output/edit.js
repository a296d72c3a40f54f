// Drag balloons, change words, save the page file with these changes. vidstyle draws the final shapes from that
// file; this script only moves and stretches them.

const KEY = "[[page.panel.words]]";
const file = JSON.parse(document.getElementById("page-file").textContent);
const [head, ...rest] = file.split(KEY);
const entries = rest.map((text) => ({ text, words: JSON.parse(/^text = (.*)$/m.exec(text)[1]) }));
const groups = [...document.querySelectorAll("g[data-place]")];
const inCapitals = /^font = "comic"$/m.test(head);
const past = [];
/** New words are broken again if a line is longer than the longest one was by this factor. */
const MAX_LINE_GAIN = 1.3;
/** Lines that are too many grow by this factor. */
const LINE_GROWTH = 1.03;
/** A pointer that moves less far clicks. */
const MIN_DRAG_DISTANCE_PX = 3;
/** What can be done with the words, and what to do with the file. */
const HINT = "Click a balloon to change its words, or drag it";
const NEXT = "Saved to your downloads. Draw the pages again with: vidstyle comic comic.toml comic.html";
const KEYS_HELP = { Enter: "change the words of the chosen balloon", "\u2190 \u2191": "move it; with Shift, farther" };
const pen = document.createElement("canvas").getContext("2d");

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
for (const bubble of bubbles) {
  // The lines and the length of the longest one, as vidstyle has drawn them.
  const lines = bubble.texts.map((each) => each.textContent.trim());
  const longest = Math.max(...bubble.texts.map((each) => Number(each.getAttribute("textLength"))));
  Object.assign(bubble, { first: bubble.place, wordsBefore: bubble.words, lines, longest });
}

/** Return the length of a line in the font of this page. */
function lengthOf({ group }, line) {
  pen.font = `${group.querySelector("text").getAttribute("font-size")}px ${getComputedStyle(group).fontFamily}`;
  return pen.measureText((inCapitals ? line.toUpperCase() : line).replace(/\*(\w(?:[^*]*\w)?)\*/g, "$1")).width;
}

/** Return the length of a line as vidstyle draws it: its font may be missing here. */
function drawnLength(bubble, line) {
  const longest = Math.max(...bubble.lines.map((each) => lengthOf(bubble, each)));
  return (lengthOf(bubble, line) * bubble.longest) / (longest || bubble.longest);
}

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
      row.setAttribute("textLength", drawnLength(bubble, line));
      row.setAttribute("lengthAdjust", "spacingAndGlyphs");
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

/** Return the fewest lines of these words that are no longer than a limit. */
function broken(bubble, words, limit) {
  const lines = [];
  for (const word of words) {
    const longer = lines.length ? `${lines.at(-1)} ${word}` : "";
    if (longer && drawnLength(bubble, longer) <= limit) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

/** Return words in at most this number of lines, of lengths as equal as possible. */
function balanced(bubble, words, count) {
  let limit = drawnLength(bubble, words.join(" ")) / count;
  let lines = broken(bubble, words, limit);
  for (; lines.length > count; lines = broken(bubble, words, limit)) limit *= LINE_GROWTH;
  return lines;
}

/** Return words in lines as they were typed; if a line is too long, in lines whose shape is most like that of the words before. */
function inLines(bubble, typed) {
  const lines = typed.split("\n");
  if (lines.every((line) => drawnLength(bubble, line) <= MAX_LINE_GAIN * bubble.longest)) return typed;
  const words = typed.split(/\s+/);
  const aspect = bubble.longest / bubble.wordsBefore.split("\n").length;
  const shapes = words.map((_, more) => balanced(bubble, words, more + 1));
  const distance = (shape) => Math.abs(Math.log(Math.max(...shape.map((line) => drawnLength(bubble, line))) / shape.length / aspect));
  return shapes.sort((one, other) => distance(one) - distance(other))[0].join("\n");
}

/** Return the place around the same centre, stretched like the words, in its panel. */
function stretched(bubble, words) {
  const lines = words.split("\n");
  const [left, top, right, bottom] = bubble.place;
  const [x, y] = [(left + right) / 2, (top + bottom) / 2];
  const wide = Math.max(...lines.map((line) => drawnLength(bubble, line))) / bubble.longest;
  const high = lines.length / bubble.wordsBefore.split("\n").length;
  const across = ((bubble.first[2] - bubble.first[0]) / 2) * wide;
  const down = ((bubble.first[3] - bubble.first[1]) / 2) * high;
  const frame = bubble.group.closest("g[id^=panel-]").querySelector(".frame").getBBox();
  const place = [x - across, y - down, x + across, y + down];
  const shift = (from, to, low, high) => (to - from > high - low ? (low + high - from - to) / 2 : Math.max(low - from, Math.min(0, high - to)));
  const [dx, dy] = [shift(place[0], place[2], frame.x, frame.x + frame.width), shift(place[1], place[3], frame.y, frame.y + frame.height)];
  return [place[0] + dx, place[1] + dy, place[2] + dx, place[3] + dy];
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
    const typed = input.value.split("\n").map((line) => line.trim()).filter(Boolean).join("\n");
    const words = typed && typed !== bubble.words ? inLines(bubble, typed) : "";
    input.remove();
    if (words) change(bubble, { words, place: stretched(bubble, words) });
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
  const isDrag = (to) => Math.hypot(to.clientX - event.clientX, to.clientY - event.clientY) > MIN_DRAG_DISTANCE_PX;
  const move = (to) => {
    if (bubble.place === from && !isDrag(to)) return;
    bubble.place = shifted(to);
    draw(bubble);
  };
  const drop = (to) => {
    group.removeEventListener("pointermove", move);
    group.classList.remove("held");
    bubble.place = from;
    if (isDrag(to)) change(bubble, { place: shifted(to) });
    else edit(bubble);
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
  note.textContent = NEXT;
}

function button(text, press, name = "") {
  const made = Object.assign(document.createElement("button"), { type: "button", textContent: text, className: name });
  made.addEventListener("click", press);
  return made;
}

const note = Object.assign(document.createElement("span"), { textContent: HINT, role: "status" });
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
    else group.addEventListener("click", () => edit(bubble));
  }
  for (const [keys, help] of Object.entries(KEYS_HELP)) {
    const [term, text] = ["dt", "dd"].map((name) => document.createElement(name));
    term.append(...keys.split(" ").map((key) => Object.assign(document.createElement("kbd"), { textContent: key })));
    text.textContent = help;
    document.querySelector("#help dl").append(term, text);
  }
  const bar = Object.assign(document.createElement("div"), { className: "bar" });
  const close = button("\u00d7", () => bar.remove(), "plain");
  close.title = close.ariaLabel = "Hide this bar";
  bar.append(note, undo, button("Save changes", save, "main"), close);
  document.body.append(bar);
}

// An example to restyle until a file is opened: a lake at sunset, with a balloon, a house and trees.

const [WIDTH, HEIGHT] = [1280, 720];
const HORIZON_PX = 470;

/** Returns the address of the picture. */
export function examplePicture() {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [WIDTH, HEIGHT];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  fill(context, [0, 0, WIDTH, HORIZON_PX], ["#2b5fa8", "#7fb2d9", "#f6c98a", "#f79b5a"]);
  sun(context, 860, 330);
  ridge(context, 300, 70, 0.9, ["#8d86b8", "#b79bb0"]);
  ridge(context, 370, 55, 2.3, ["#4f6a8f", "#7a7f9c"]);
  fill(context, [0, HORIZON_PX, WIDTH, HEIGHT - HORIZON_PX], ["#e8a06a", "#5f86ad", "#1f3f66"]);
  waves(context);
  ridge(context, 452, 26, 4.1, ["#35573f", "#1f3527"], 640);
  house(context, 170, 380);
  for (const [x, y, size] of [[70, 440, 62], [400, 448, 44], [520, 456, 34]]) tree(context, x, y, size);
  balloon(context, 980, 160, 84);
  return canvas.toDataURL("image/jpeg", 0.92);
}

/** @param {CanvasRenderingContext2D} context @param {number[]} box @param {string[]} colors from top to bottom */
function fill(context, [x, y, width, height], colors) {
  const shades = context.createLinearGradient(0, y, 0, y + height);
  colors.forEach((color, place) => shades.addColorStop(place / (colors.length - 1), color));
  context.fillStyle = shades;
  context.fillRect(x, y, width, height);
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y */
function sun(context, x, y) {
  const glow = context.createRadialGradient(x, y, 30, x, y, 260);
  glow.addColorStop(0, "#fff6d0");
  glow.addColorStop(0.2, "#ffe3a0cc");
  glow.addColorStop(1, "#ffd08a00");
  context.fillStyle = glow;
  context.fillRect(x - 260, y - 260, 520, 520);
}

/** @param {CanvasRenderingContext2D} context @param {number} top @param {number} high @param {number} phase @param {string[]} colors @param {number} [right] */
function ridge(context, top, high, phase, colors, right = WIDTH) {
  context.save();
  context.beginPath();
  context.moveTo(0, HORIZON_PX + 8);
  for (let x = 0; x <= right; x += 8) {
    const fade = right < WIDTH ? (1 - x / right) ** 0.4 : 1;
    const rise = Math.sin(x / 170 + phase) + 0.5 * Math.sin(x / 61 + 2 * phase) + 0.16 * Math.sin(x / 17 + phase);
    context.lineTo(x, HORIZON_PX + 8 - fade * (HORIZON_PX + 8 - top + high * rise));
  }
  context.lineTo(right, HORIZON_PX + 8);
  context.clip();
  fill(context, [0, top - 2 * high, right, HORIZON_PX + 8 - top + 2 * high], colors);
  context.restore();
}

/** @param {CanvasRenderingContext2D} context */
function waves(context) {
  for (let line = 0; line < 70; line++) {
    const y = HORIZON_PX + 6 + line * line * 0.052;
    context.fillStyle = line % 3 ? "#ffd9a855" : "#16325455";
    context.fillRect(860 - 260 * Math.abs(Math.sin(line * 1.7)) - line * 3, y, 90 + 150 * Math.abs(Math.sin(line * 2.9)) + line * 3, 1.2 + line / 24);
  }
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y */
function house(context, x, y) {
  fill(context, [x, y, 130, 84], ["#f2e3c6", "#cdb48a"]);
  context.fillStyle = "#8f3b2e";
  context.beginPath();
  for (const [dx, dy] of [[-16, 4], [65, -62], [146, 4]]) context.lineTo(x + dx, y + dy);
  context.fill();
  for (const [dx, dy, w, h, color] of /** @type {[number, number, number, number, string][]} */ ([[18, 22, 26, 28, "#33506b"], [86, 22, 26, 28, "#ffd36b"], [54, 34, 24, 50, "#5b3a29"]])) {
    context.fillStyle = color;
    context.fillRect(x + dx, y + dy, w, h);
  }
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} size */
function tree(context, x, y, size) {
  context.fillStyle = "#4a3424";
  context.fillRect(x - size / 12, y - size / 2, size / 6, size);
  for (let leaf = 0; leaf < 90; leaf++) {
    const [turn, far] = [leaf * 2.4, size * Math.sqrt(leaf / 90)];
    context.fillStyle = ["#2e5a34", "#3f7a3f", "#6f9a45", "#c9a24a"][Math.floor(4 * Math.abs(Math.sin(leaf * leaf)))];
    context.beginPath();
    context.arc(x + far * Math.cos(turn), y - size * 1.1 + far * Math.sin(turn), size / 9, 0, 7);
    context.fill();
  }
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} size */
function balloon(context, x, y, size) {
  ["#c8322d", "#f3efe4", "#c8322d", "#f3efe4", "#c8322d"].forEach((color, stripe) => {
    context.fillStyle = color;
    context.beginPath();
    context.ellipse(x, y, size * (1 - stripe / 4.6), size * 1.1, 0, 0, 7);
    context.fill();
  });
  context.strokeStyle = "#3a2b22";
  context.lineWidth = 2;
  for (const side of [-1, 1]) {
    context.beginPath();
    context.moveTo(x + side * size * 0.5, y + size * 0.95);
    context.lineTo(x + side * 15, y + size * 1.5);
    context.stroke();
  }
  context.fillStyle = "#7a4d2b";
  context.fillRect(x - 17, y + size * 1.5, 34, 24);
}

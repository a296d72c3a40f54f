// Pictures of panels at their size on the screen: a browser that reduces halftone dots shows moiré.

import { make, makeSvg } from "./elements.js";

/** Standard deviation of the blur before a reduction, for each pixel that becomes one: tuned on halftone dots and fine lines. */
const [MIN_BLUR_RATIO, MAX_BLUR_RATIO] = [0.6, 0.85];
/** Reductions from which the smaller blur leaves no moiré, and to which the larger one is needed. */
const [CRISP_REDUCTION, SOFT_REDUCTION] = [2, 1.5];
const JPEG_QUALITY = 0.95;

/** Safari before 18 has no filters. */
const HAS_FILTERS = "filter" in CanvasRenderingContext2D.prototype;

/** The width that a picture should have by now. @type {WeakMap<SVGImageElement, number>} */
const wanted = new WeakMap();

/**
 * Shows the pictures of a panel smoothly reduced, over the whole ones, which remain for print.
 * @param {SVGGElement} panel
 * @param {number} scale pixels of the screen for each pixel of the page
 */
export function reducePictures(panel, scale) {
  return Promise.all([.../** @type {NodeListOf<SVGImageElement>} */ (panel.querySelectorAll("image:not(.reduced)"))].map((image) => fit(image, scale)));
}

/** @param {SVGImageElement} image @param {number} scale */
async function fit(image, scale) {
  const { width, height } = image;
  const size = [width, height].map(({ baseVal: { value } }) => Math.max(1, Math.round(value * scale)));
  if (wanted.get(image) === size[0]) return;
  wanted.set(image, size[0]);
  const href = await reduced(image.href.baseVal, size);
  if (wanted.get(image) !== size[0]) return;
  if (image.nextElementSibling?.matches(".reduced")) image.nextElementSibling.remove();
  if (!href) return;
  const place = Object.fromEntries(["x", "y", "width", "height"].map((name) => [name, String(image.getAttribute(name))]));
  image.after(makeSvg("image", { ...place, href, class: "reduced", preserveAspectRatio: "none" }));
}

/** Returns the standard deviation in pixels of the blur before a reduction. @param {number} ratio of the reduction */
function deviationFor(ratio) {
  const soft = Math.min(1, Math.max(0, (CRISP_REDUCTION - ratio) / (CRISP_REDUCTION - SOFT_REDUCTION)));
  return (MIN_BLUR_RATIO + soft * (MAX_BLUR_RATIO - MIN_BLUR_RATIO)) * Math.sqrt(Math.max(0, ratio * ratio - 1));
}

/** Draws a blurred picture. @param {CanvasRenderingContext2D} context @param {HTMLImageElement} picture @param {number} deviation in pixels */
function drawBlurred(context, picture, deviation) {
  if (HAS_FILTERS) {
    context.filter = `blur(${deviation}px)`;
    context.drawImage(picture, 0, 0);
    return;
  }
  // The mean of shifted pictures, whose shifts have this deviation.
  const shifts = [-2, -1, 0, 1, 2].map((shift) => (shift * deviation) / Math.SQRT2);
  shifts.flatMap((y) => shifts.map((x) => [x, y])).forEach(([x, y], number) => {
    context.globalAlpha = 1 / (number + 1);
    context.drawImage(picture, x, y);
  });
}

/** Returns a smaller picture; "" if it is not smaller. @param {string} src @param {number[]} size @returns {Promise<string>} */
async function reduced(src, size) {
  const picture = make("img", { src });
  await picture.decode();
  const { naturalWidth: width, naturalHeight: height } = picture;
  const ratio = Math.max(width / size[0], height / size[1]);
  if (ratio <= 1) return "";
  const [blurred, small] = [make("canvas", { width, height }), make("canvas", { width: size[0], height: size[1] })];
  const context = /** @type {CanvasRenderingContext2D} */ (blurred.getContext("2d"));
  context.drawImage(picture, 0, 0); // remains at the edges, where the blurred one is transparent
  drawBlurred(context, picture, deviationFor(ratio));
  small.getContext("2d")?.drawImage(blurred, 0, 0, size[0], size[1]);
  return small.toDataURL("image/jpeg", JPEG_QUALITY);
}

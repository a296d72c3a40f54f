// The picture that a page saves, and its name.

/** Returns the name of a result: that of its source, if it has one, and of its style. @param {string} source @param {string} look @param {string} extension */
export const nameOfResult = (source, look, extension) => `${source ? `${source}-` : ""}${look}.${extension}`;

/**
 * Returns a picture as PNG, reduced to the size of its source: marks are drawn finer than a small source.
 * @param {HTMLCanvasElement} canvas
 * @param {[number, number]} own the size of the source
 * @returns {Promise<{blob: Blob | null, size: [number, number]}>}
 */
export async function pngOf(canvas, own) {
  const isLarger = canvas.width > own[0];
  const saved = isLarger ? document.createElement("canvas") : canvas;
  if (isLarger) {
    [saved.width, saved.height] = own;
    const context = /** @type {CanvasRenderingContext2D} */ (saved.getContext("2d"));
    context.imageSmoothingQuality = "high";
    context.drawImage(canvas, 0, 0, ...own);
  }
  return { blob: await new Promise((done) => saved.toBlob(done)), size: [saved.width, saved.height] };
}

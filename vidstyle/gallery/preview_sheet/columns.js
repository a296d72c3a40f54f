// The columns of thumbnails, and the words that fit under each.

/** Width of a column, in CSS pixels, from which there is one more. */
const COLUMN_PX = 290;
/** The narrowest column of pictures in portrait, relative to it. */
const MIN_COLUMN_RATIO = 0.65;
const MIN_COLUMNS = 2;
/** Height of what is below a thumbnail, and above all of them, in CSS pixels. */
const [CAPTION_PX, ABOVE_PX] = [100, 130];

/**
 * Returns a number of columns that fills the last row, as far as possible; pictures in portrait get more columns, few pictures more width.
 * @param {number} width of all columns, in CSS pixels
 * @param {number} aspect of the pictures
 * @param {number} seen the number of pictures that are shown
 * @param {number} total the number of all pictures
 */
export function columnsFor(width, aspect, seen, total) {
  const isPortrait = aspect < 1;
  const columnPx = COLUMN_PX * (isPortrait ? Math.max(MIN_COLUMN_RATIO, aspect) : 1);
  const usual = Math.max(MIN_COLUMNS, Math.floor(width / columnPx));
  const empty = (/** @type {number} */ columns) => (columns - (total % columns)) % columns;
  const tried = usual > MIN_COLUMNS ? [usual, ...(isPortrait ? [] : [usual - 1]), usual + 1] : [usual];
  const [best] = tried.sort((one, other) => empty(one) - empty(other));
  return fewest(width, aspect, seen) ?? best;
}

/** Returns the fewest columns in which all pictures are seen without scrolling; undefined if there are too many. @param {number} width @param {number} aspect @param {number} count of pictures */
function fewest(width, aspect, count) {
  for (let columns = MIN_COLUMNS; columns * COLUMN_PX <= width; columns++) {
    const rows = Math.ceil(count / columns);
    if (rows * (width / columns / aspect + CAPTION_PX) <= innerHeight - ABOVE_PX) return columns;
  }
}

/** Shows as many words of a text as fit into an element. @param {HTMLElement} element @param {string} text */
export function shorten(element, text) {
  element.textContent = text;
  if (element.scrollHeight <= element.clientHeight) return;
  const words = text.split(" ");
  let [fits, above] = [0, words.length];
  while (above - fits > 1) {
    const middle = Math.floor((fits + above) / 2);
    element.textContent = `${words.slice(0, middle).join(" ").replace(/[,;:.]$/, "")} …`;
    if (element.scrollHeight <= element.clientHeight) fits = middle;
    else above = middle;
  }
  element.textContent = `${words.slice(0, fits).join(" ").replace(/[,;:.]$/, "")} …`;
}

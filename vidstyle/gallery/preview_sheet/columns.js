// The columns of thumbnails.

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
  const empty = (/** @type {number} */ columns, count = total) => (columns - (count % columns)) % columns;
  const tried = usual > MIN_COLUMNS ? [usual, ...(isPortrait ? [] : [usual - 1]), usual + 1] : [usual];
  const [best] = tried.sort((one, other) => empty(one) - empty(other));
  const few = fewest(width, aspect, seen);
  if (!few) return best;
  return empty(few + 1, seen) < empty(few, seen) ? few + 1 : few;
}

/** Returns the fewest columns in which all pictures are seen without scrolling; undefined if there are too many. @param {number} width @param {number} aspect @param {number} count of pictures */
function fewest(width, aspect, count) {
  for (let columns = MIN_COLUMNS; columns * COLUMN_PX <= width; columns++) {
    const rows = Math.ceil(count / columns);
    if (rows * (width / columns / aspect + CAPTION_PX) <= innerHeight - ABOVE_PX) return columns;
  }
}

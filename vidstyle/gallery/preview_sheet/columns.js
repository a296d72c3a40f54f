// The columns of thumbnails.

/** Width of a column, in CSS pixels, from which there is one more. */
const COLUMN_PX = 290;
/** In wide windows, thumbnails grow instead. */
const MAX_COLUMNS = 7;
/** The narrowest column of pictures in portrait, relative to it. */
const MIN_COLUMN_RATIO = 0.65;
const MIN_COLUMNS = 2;

/**
 * Returns a number of columns that fills the last row, as far as possible; pictures in portrait get more columns.
 * @param {number} width of all columns, in CSS pixels
 * @param {number} aspect of the pictures
 * @param {number} total the number of all pictures, whichever are shown
 */
export function columnsFor(width, aspect, total) {
  const isPortrait = aspect < 1;
  const columnPx = Math.max(COLUMN_PX, width / MAX_COLUMNS) * (isPortrait ? Math.max(MIN_COLUMN_RATIO, aspect) : 1);
  const usual = Math.max(MIN_COLUMNS, Math.floor(width / columnPx));
  const empty = (/** @type {number} */ columns) => (columns - (total % columns)) % columns;
  const tried = usual > MIN_COLUMNS ? [usual, ...(isPortrait ? [] : [usual - 1]), usual + 1] : [usual];
  const [best] = tried.sort((one, other) => empty(one) - empty(other));
  return best;
}

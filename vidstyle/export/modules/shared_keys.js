// The keys that mean the same on all pages, by what they do.

export const SHARED_KEYS = {
  /** Hold to see the original. */
  original: "b",
  /** Compare with the original, or with another style. */
  compare: "c",
  /** Save or keep what is shown. */
  save: "s",
  play: "p",
  /** Enlarge the picture. */
  zoom: "z",
  full: "f",
  /** The next style, or new ones. */
  next: "n",
  help: "?",
};

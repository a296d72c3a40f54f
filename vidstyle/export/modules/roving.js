// Groups with one stop of the Tab key.

/**
 * Makes a group one stop of the Tab key, with arrow keys between its members, also where they stand in rows.
 * @param {HTMLElement} group
 * @param {string} selector of its members
 */
export function rove(group, selector) {
  const members = () => /** @type {HTMLElement[]} */ ([...group.querySelectorAll(selector)]).filter((each) => !each.hidden && !each.parentElement?.hidden);
  /** @param {HTMLElement} [chosen] */
  const mark = (chosen = members()[0]) => {
    for (const each of /** @type {NodeListOf<HTMLElement>} */ (group.querySelectorAll(selector))) each.tabIndex = each === chosen ? 0 : -1;
  };
  group.addEventListener("focusin", ({ target }) => {
    if (/** @type {HTMLElement} */ (target).matches(selector)) mark(/** @type {HTMLElement} */ (target));
  });
  group.addEventListener("keydown", (event) => {
    const next = neighbour(members(), /** @type {HTMLElement} */ (event.target), event.key);
    if (!next) return;
    event.preventDefault();
    next.focus();
  });
  const ensure = () => members().filter((each) => each.tabIndex === 0).length === 1 || mark();
  ensure();
  new MutationObserver(ensure).observe(group, { childList: true, subtree: true, attributeFilter: ["hidden"] });
}

/** Returns the member to which a key moves. @param {HTMLElement[]} members @param {HTMLElement} from @param {string} key */
function neighbour(members, from, key) {
  const at = members.indexOf(from);
  const tops = members.map((each) => Math.round(each.getBoundingClientRect().top));
  const inRow = members.filter((_, place) => tops[place] === tops[0]).length;
  const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -inRow, ArrowDown: inRow, Home: -at, End: members.length - 1 - at };
  const step = steps[/** @type {keyof typeof steps} */ (key)];
  return at < 0 || !step ? undefined : members[at + step];
}

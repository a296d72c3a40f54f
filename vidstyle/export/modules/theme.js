// Light or dark pages: as the system, unless the user has chosen.

const KEY = "theme";

/** Shows the theme that the user has chosen on this page, and makes a button switch it. @param {HTMLElement} button */
export function switchTheme(button) {
  const root = document.documentElement;
  const isDark = () => (root.style.colorScheme ? root.style.colorScheme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);
  const show = () => {
    button.setAttribute("aria-label", isDark() ? "Light theme" : "Dark theme");
    button.title = isDark() ? "Light theme" : "Dark theme";
  };
  root.style.colorScheme = read();
  show();
  button.addEventListener("click", () => {
    root.style.colorScheme = isDark() ? "light" : "dark";
    try {
      localStorage.setItem(KEY, root.style.colorScheme);
    } catch {
      // Pages from files may not keep anything.
    }
    show();
  });
}

/** Returns the chosen theme; "" if there is none. */
function read() {
  try {
    const theme = localStorage.getItem(KEY) ?? "";
    return ["light", "dark"].includes(theme) ? theme : "";
  } catch {
    return "";
  }
}

// What users do in nearly every test.

/** Shows a view. */
export const view = (page, name) => page.getByRole("navigation").getByRole("link", { name, exact: true }).click();

/** Fills a field of a form, or chooses there; its group is opened if it is closed. */
export async function fill(page, name, value) {
  const field = page.locator(`:is(input, select)[name="${name}"]`);
  await field.waitFor({ state: "attached" });
  if (!(await field.isVisible())) {
    for (const group of await page.locator("details", { has: field }).all()) {
      if ((await group.getAttribute("open")) === null) await group.locator("summary").first().click();
    }
  }
  if ((await field.evaluate(({ tagName }) => tagName)) === "SELECT") await field.selectOption(value);
  else await field.fill(value);
  await field.blur();
}

/** Starts the identification with an operator. */
export async function identify(page, operator) {
  await view(page, "Workbench");
  await fill(page, "operator", operator);
  await page.getByRole("button", { name: "Identify", exact: true }).click();
}

/** The heading of a model of which all is known. */
export const known = (page, name, timeout = 120_000) => page.getByRole("heading", { name, exact: true, level: 2 }).waitFor({ timeout });

/** Repeats a check of files until it holds: the page writes them a moment after a change. */
export async function written(check, end = Date.now() + 30_000) {
  for (;;) {
    try {
      return check();
    } catch (fault) {
      if (Date.now() > end) throw fault;
    }
    await new Promise((passed) => setTimeout(passed, 50));
  }
}

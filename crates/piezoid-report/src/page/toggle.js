(function () {
  var root = document.documentElement, button = document.createElement("button");
  function dark() {
    var set = root.getAttribute("data-theme");
    return set ? set === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  }
  function show() { button.textContent = dark() ? "Light" : "Dark"; }
  button.type = "button";
  button.className = "theme";
  button.setAttribute("aria-label", "Switch between light and dark");
  button.onclick = function () { root.setAttribute("data-theme", dark() ? "light" : "dark"); show(); };
  show();
  document.querySelector("header").appendChild(button);
})();

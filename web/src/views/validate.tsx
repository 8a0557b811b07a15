export function ValidateView() {
  return <p class="missing">Not built yet.</p>;
}

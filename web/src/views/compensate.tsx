export function CompensateView() {
  return <p class="missing">Not built yet.</p>;
}

export function ControlView() {
  return <p class="missing">Not built yet.</p>;
}

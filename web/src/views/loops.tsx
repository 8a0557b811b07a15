export function LoopsView() {
  return <p class="missing">Not built yet.</p>;
}

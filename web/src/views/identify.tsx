export function IdentifyView() {
  return <p class="missing">Not built yet.</p>;
}

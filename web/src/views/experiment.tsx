export function ExperimentView() {
  return <p class="missing">Not built yet.</p>;
}

export function ExportView() {
  return <p class="missing">Not built yet.</p>;
}

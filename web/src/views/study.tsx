export function StudyView() {
  return <p class="missing">Not built yet.</p>;
}

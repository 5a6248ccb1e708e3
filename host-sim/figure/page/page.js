// Enlarges a drawing; the page is complete without this.
(() => {
  const zoom = document.getElementById('zoom'), sheet = zoom.querySelector('div');
  let scale = 1, width = 0;
  const show = () => { const svg = sheet.firstElementChild; if (svg) svg.style.width = width * scale + 'px'; };
  const open = (drawing) => {
    const copy = drawing.firstElementChild.cloneNode(true);
    // Names are unique on a page: the copy gets its own.
    copy.innerHTML = copy.innerHTML.replaceAll(/(id="|url\(#)/g, '$1zoomed-');
    sheet.replaceChildren(copy);
    width = 1.5 * drawing.clientWidth; scale = 1; show(); zoom.showModal();
  };
  for (const drawing of document.querySelectorAll('.drawing')) {
    drawing.addEventListener('click', () => open(drawing));
    drawing.addEventListener('keydown', (event) => { if (event.key === 'Enter') open(drawing); });
  }
  for (const button of zoom.querySelectorAll('[data-by]')) {
    button.addEventListener('click', () => { scale = Math.min(8, Math.max(0.5, scale * button.dataset.by)); show(); });
  }
  sheet.addEventListener('wheel', (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    scale = Math.min(8, Math.max(0.5, scale * Math.exp(-event.deltaY / 200))); show();
  }, { passive: false });
  zoom.addEventListener('close', () => sheet.replaceChildren());
  const contents = document.querySelector('nav details');
  if (matchMedia('(max-width: 72rem)').matches) contents.open = false;
})();

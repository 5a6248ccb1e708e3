// The keyboard. Escape stops wherever the focus is, and Space does outside of a field of text. So
// Enter does what Space does elsewhere: it presses buttons, toggles boxes and opens files.

export function listen(stop: () => void, keys: Record<string, () => void>): void {
  const isText = (target: HTMLElement) =>
    target.matches('input:not([type=checkbox]):not([type=file]), select, textarea');
  const isSlider = (target: HTMLElement) => target.matches('[type=range]');
  document.addEventListener(
    'keydown',
    (event) => {
      const target = event.target as HTMLElement;
      const typing = isText(target);
      // A slider takes the arrows, and no blank.
      if (event.key === 'Escape' || (event.key === ' ' && (!typing || isSlider(target)))) {
        event.preventDefault();
        stop();
        return;
      }
      if (event.key === 'Enter' && target.matches('[type=checkbox], [type=file]')) {
        event.preventDefault();
        target.click();
        return;
      }
      if (typing || event.ctrlKey || event.altKey || event.metaKey || !keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    },
    true,
  );
  // A button that has the focus is pressed when Space is let go: that key only stops.
  document.addEventListener(
    'keyup',
    (event) => {
      if (event.key === ' ' && !isText(event.target as HTMLElement)) event.preventDefault();
    },
    true,
  );
}

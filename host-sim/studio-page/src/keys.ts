// The keyboard. Escape stops wherever the focus is, and Space does outside of a field of text. So
// Enter does what Space does elsewhere: it presses buttons, toggles boxes and opens files. A list
// to choose from takes letters and arrows, and no blank: the arrows open it, too.

export function listen(stop: () => void, keys: Record<string, () => void>): void {
  const takesBlanks = (target: HTMLElement) =>
    target.matches('input:not([type=checkbox]):not([type=file]):not([type=range]), textarea');
  const takesKeys = (target: HTMLElement) =>
    takesBlanks(target) || target.matches('[type=range], select');
  document.addEventListener(
    'keydown',
    (event) => {
      const target = event.target as HTMLElement;
      if (event.key === 'Escape' || (event.key === ' ' && !takesBlanks(target))) {
        event.preventDefault();
        stop();
        return;
      }
      if (event.key === 'Enter' && target.matches('[type=checkbox], [type=file]')) {
        event.preventDefault();
        target.click();
        return;
      }
      // Letters are capital ones under Caps Lock. Shift is no key of these.
      const isShifted = event.shiftKey && !event.getModifierState('CapsLock');
      const then = keys[event.key] ?? (isShifted ? undefined : keys[event.key.toLowerCase()]);
      if (takesKeys(target) || event.ctrlKey || event.altKey || event.metaKey || !then) return;
      event.preventDefault();
      then();
    },
    true,
  );
  // A button that has the focus is pressed when Space is let go: that key only stops.
  document.addEventListener(
    'keyup',
    (event) => {
      if (event.key === ' ' && !takesBlanks(event.target as HTMLElement)) event.preventDefault();
    },
    true,
  );
}

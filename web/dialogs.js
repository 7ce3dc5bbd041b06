// Questions that are asked before something is changed.
import { part, setText } from './dom.js';

// Asks, does `act` when it is confirmed, and shows why it failed.
export function confirmThen({ title, text, yes }, act) {
  const dialog = part('confirm-dialog');
  setText(part('confirm-title'), title);
  setText(part('confirm-text'), text);
  setText(part('confirm-error'), '');
  const button = part('confirm-yes');
  setText(button, yes);
  button.onclick = () => closeAfter(dialog, button, part('confirm-error'), act);
  dialog.showModal();
}

export function askDescription(map, save) {
  const dialog = part('describe-dialog');
  const text = dialog.querySelector('textarea');
  text.value = map.description ?? '';
  setText(part('describe-title'), `Describe ${map.name}`);
  setText(part('describe-error'), '');
  const button = part('describe-save');
  button.onclick = () => closeAfter(dialog, button, part('describe-error'), () => save(text.value.trim()));
  dialog.showModal();
}

export const whyRefused = (error) => (error.status === 403 ? `Your token does not allow this: ${error.message}` : error.message);

async function closeAfter(dialog, button, place, act) {
  button.disabled = true;
  try {
    await act();
    dialog.close();
  } catch (error) {
    setText(place, whyRefused(error));
  } finally {
    button.disabled = false;
  }
}

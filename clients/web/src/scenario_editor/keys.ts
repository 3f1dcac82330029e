// Keys of the scenario editor: what moves, stretches and removes the chosen event, undo and redo.
import type {ScenarioEditor} from './scenario_editor';

const kStep_s = 0.5;
const kFine_s = 0.1;
/** Elements that have a use for these keys themselves. */
const kOwnUse = 'input, select, textarea, summary';

export function onScenarioKey(editor: ScenarioEditor, panel: HTMLElement): void {
  addEventListener('keydown', (event) => {
    const at = event.target instanceof Element ? event.target : document.body;
    const isOurs = at === document.body || panel.contains(at);
    if (!editor.open || !isOurs || at.closest(kOwnUse) || document.querySelector('dialog[open]'))
      return;
    if (run(editor, event)) event.preventDefault();
  });
}

function run(editor: ScenarioEditor, event: KeyboardEvent): boolean {
  const {key, shiftKey, ctrlKey, metaKey} = event;
  if (ctrlKey || metaKey) {
    if (/^y$/i.test(key) || (/^z$/i.test(key) && shiftKey)) editor.redo();
    else if (/^z$/i.test(key)) editor.undo();
    else return false;
    return true;
  }
  const {chosen} = editor;
  if (!chosen) return false;
  const step_s = shiftKey ? kFine_s : kStep_s;
  if (key === 'ArrowLeft') editor.shift(-step_s);
  else if (key === 'ArrowRight') editor.shift(step_s);
  else if (key === 'ArrowUp') editor.stretch(step_s);
  else if (key === 'ArrowDown') editor.stretch(-step_s);
  else if (key === 'Delete') editor.remove(chosen);
  else return false;
  return true;
}

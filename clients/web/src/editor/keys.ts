// Keys of the scene editor: what moves, turns and removes the chosen thing, undo and redo.
import type {SceneEditor} from './scene_editor';

const kStep_m = 0.005;
const kFine_m = 0.001;
const kTurn_deg = 15;
const kArrows: {[key: string]: [number, number]} = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1]
};
/** Elements that have a use for these keys themselves. */
const kOwnUse = 'input, select, textarea, [role=tablist], summary';

export function onEditorKey(editor: SceneEditor, panel: HTMLElement): void {
  addEventListener('keydown', (event) => {
    const at = event.target instanceof Element ? event.target : document.body;
    const isOurs = at === document.body || panel.contains(at) || at.closest('main.stage') !== null;
    if (!editor.open || !isOurs || at.closest(kOwnUse) || document.querySelector('dialog[open]'))
      return;
    if (run(editor, event)) event.preventDefault();
  });
}

function run(editor: SceneEditor, event: KeyboardEvent): boolean {
  const {key, shiftKey, ctrlKey, metaKey} = event;
  if (ctrlKey || metaKey) {
    if (/^y$/i.test(key) || (/^z$/i.test(key) && shiftKey)) void editor.redo();
    else if (/^z$/i.test(key)) void editor.undo();
    else return false;
    return true;
  }
  const {chosen} = editor;
  const arrow = kArrows[key];
  if (!chosen || editor.busy) return arrow !== undefined && chosen !== null;
  if (arrow) {
    const step_m = shiftKey ? kFine_m : kStep_m;
    void editor.shift(arrow[0] * step_m, arrow[1] * step_m, 0);
  } else if (key === 'R') void editor.shift(0, 0, -kTurn_deg);
  else if (key === 'Delete') void editor.remove(chosen);
  else return false;
  return true;
}

import {EditorPanel} from './editor/editor_panel';
import {makeView, type Layers} from './scene/cell_view';
import {ScenarioPanel} from './scenario_editor/scenario_panel';
import {State} from './state';
import {Access} from './ui/access';
import {CameraPanel} from './ui/camera_panel';
import {ChartPanel} from './ui/chart_panel';
import {ConveyorPanel} from './ui/conveyor_panel';
import {button, h, notify, text} from './ui/dom';
import {FaultPanel} from './ui/fault_panel';
import {FaultTimeline} from './ui/fault_timeline';
import {Shortcuts} from './ui/help';
import {HistoryLine} from './ui/history_line';
import {InjectCard} from './ui/inject_card';
import {InjectedCard} from './ui/injected_card';
import {Jog} from './ui/jog';
import {PickCard} from './ui/pick_card';
import {pictureButtons} from './ui/pictures';
import {RobotPanel} from './ui/robot_panel';
import {RobotSwitch} from './ui/robot_switch';
import {Programs} from './ui/programs';
import {RunCard} from './ui/run_card';
import {StartCard} from './ui/start_card';
import {Tabs} from './ui/tabs';
import {Toolbar} from './ui/toolbar';
import {TrafficPanel} from './ui/traffic_panel';
import {units} from './ui/units';

/** Layer, label, key, tooltip. */
const kLayerNames: [keyof Layers, string, string, string][] = [
  ['names', 'Names', 'l', 'Names of robots, trays and tools'],
  ['trails', 'Tool paths', 't', 'Recent paths of the tools'],
  ['targets', 'Move targets', 'x', 'Pose at which each running move ends'],
  ['contacts', 'Contacts', 'c', 'Contact points and their forces'],
  ['groups', 'Resting groups', 'g', 'Colours of bodies that physics simplifies as one group'],
  ['cameras', 'Cameras', 'v', 'Areas and detections of the cameras'],
  ['curtain', 'Light beams', 'b', 'Light curtain and photo-eyes']
];

const state = new State();
const access = new Access(state);
const stage = h('main', {class: 'stage'});
const view = makeView(stage, state);
Object.assign(stage, {view}); // where tests look up what is drawn
view.onProblem = (message) => notify(message, 'error');
const jog = new Jog(state, access);
const robotSwitch = new RobotSwitch(state, access);

const robotsPanel = h('div', {class: 'panel robots'});
let robots: RobotPanel[] = [];
const conveyor = new ConveyorPanel(state, access);
const crcl = new TrafficPanel(state, 'crcl');
const modbus = new TrafficPanel(state, 'modbus');
const cameras = new CameraPanel(state);
const charts = new ChartPanel(state);
Object.assign(stage, {charts}); // read by tests, as the view is
const faults = new FaultPanel(state);
const injected = new InjectedCard(state, access);
const programs = new Programs(state);
const scenarioPanel = new ScenarioPanel(state, access, programs);
const runCard = new RunCard(state, access, programs, (name) => void scenarioPanel.begin(name));
const scenarios = h(
  'div',
  {class: 'panel'},
  runCard.element,
  new InjectCard(state, access).element,
  injected.element
);
const editor = new EditorPanel(state, access, view);
const kScenarios = 6; // index of the panel
const tabs = new Tabs(
  [
    {name: 'Robots', content: robotsPanel, docs: 'crcl.html'},
    {name: 'Conveyor', content: conveyor.element, docs: 'modbus.html'},
    {name: 'CRCL', content: crcl.element, docs: 'crcl.html'},
    {name: 'Modbus', content: modbus.element, docs: 'reference/registers.html'},
    {name: 'Charts', content: charts.element, docs: 'web_page.html'},
    {name: 'Faults', content: faults.element, docs: 'troubleshooting.html', mark: faults.count},
    {name: 'Scenarios', content: scenarios, docs: 'scenarios.html', mark: injected.count},
    {name: 'Cameras', content: cameras.element, docs: 'cameras.html'},
    {name: 'Scene', content: editor.element, docs: 'web_page.html#the-scene-editor'}
  ],
  (name) => {
    cameras.show(name === 'Cameras');
    state.watch({
      crcl: name === 'CRCL',
      modbus: name === 'Modbus',
      registers: name === 'Conveyor',
      polls: (name === 'CRCL' && crcl.wantsPolls) || (name === 'Modbus' && modbus.wantsPolls)
    });
  }
);

const layerButtons = new Map(
  kLayerNames.map(([layer, label, key, meaning]) => [
    layer,
    button(label, () => toggleLayer(layer), {
      'aria-pressed': String(view.layers[layer]),
      title: `${meaning} (${key})`,
      'data-testid': `layer-${layer}`
    })
  ])
);

function toggleLayer(layer: keyof Layers): void {
  view.setLayer(layer, !view.layers[layer]);
  layerButtons.get(layer)!.setAttribute('aria-pressed', String(view.layers[layer]));
  if (layer === 'trails') view.clearTrails();
}

function setTheme(dark: boolean): void {
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
  view.setTheme(dark);
}
function changeTheme(): void {
  const dark = document.documentElement.dataset.theme !== 'dark';
  localStorage.setItem('theme', dark ? 'dark' : 'light');
  setTheme(dark);
}
const isLight = matchMedia('(prefers-color-scheme: light)');
/** The chosen colours, or the system's where none were chosen. */
function followTheme(): void {
  setTheme((localStorage.getItem('theme') ?? (isLight.matches ? 'light' : 'dark')) === 'dark');
}
isLight.addEventListener('change', followTheme);

const shortcuts = new Shortcuts(
  [
    {keys: [' '], does: 'pause or resume', run: () => toolbar.toggle()},
    {
      keys: ['.'],
      does: 'one step while paused; hold to repeat',
      run: (_, held) => toolbar.takeSteps(1, held),
      repeats: true
    },
    {
      keys: [','],
      does: '100 steps while paused; hold to repeat',
      run: (_, held) => toolbar.takeSteps(100, held),
      repeats: true
    },
    {
      keys: ['['],
      does: '1 ms back in the recorded past; hold to repeat',
      run: () => historyLine.move(-1),
      repeats: true
    },
    {
      keys: [']'],
      does: '1 ms forward in the recorded past; hold to repeat',
      run: () => historyLine.move(1),
      repeats: true
    },
    {keys: ['n'], does: 'from the past to now', run: () => historyLine.leave()},
    {
      keys: ['s', 'Escape'],
      does: 'stop all robots and the belt; Escape first closes what is open',
      run: () => toolbar.stopCell()
    },
    {
      keys: ['r'],
      does: 'the next robot; in the scene editor, turn the chosen thing',
      run: () => editor.turn() || robotSwitch.chooseNext()
    },
    {keys: ['h'], does: 'initial view', run: () => view.goHome()},
    {
      keys: ['d'],
      does: 'dark or light colours',
      run: changeTheme
    },
    ...kLayerNames.map(([layer, label, key]) => ({
      keys: [key],
      does: `show or hide ${label.toLowerCase()}`,
      run: () => toggleLayer(layer)
    })),
    {
      keys: ['1', '2', '3', '4', '5', '6', '7', '8', '9'],
      does: 'the panels, from left to right',
      run: (key) => tabs.open(Number(key) - 1)
    },
    {keys: ['?'], does: 'this list', run: () => shortcuts.show()}
  ],
  [
    () => robots.some((panel) => panel.closePreview()),
    () => pick.close(),
    () => scenarioPanel.close(),
    () => editor.close(),
    () => crcl.closeDetail() || modbus.closeDetail(),
    () => start.close()
  ]
);

const toolbar = new Toolbar(state, access, changeTheme, () => shortcuts.show());
toolbar.element.querySelector('.brand')!.addEventListener('click', (event) => {
  event.preventDefault();
  view.goHome();
});

const pick = new PickCard(state, view, robotSwitch);
view.onPick = (picked) => editor.takePick(picked) || pick.show(picked);
pick.onTarget = (name, position_R) => {
  tabs.open(0);
  robots[robotSwitch.chosen]?.setTarget(position_R);
  notify(`The target now has x, y and z of ${name}.`);
};
const start = new StartCard(state, access, programs, () => {
  tabs.open(kScenarios);
  runCard.element.scrollIntoView();
});
if (view.draws)
  stage.append(
    h(
      'div',
      {class: 'layers', role: 'group', 'aria-label': 'Content of the view'},
      ...layerButtons.values(),
      button('Initial view', () => view.goHome(), {title: 'Back to the initial view (h)'}),
      ...pictureButtons(view, 'aprsim')
    )
  );
stage.append(pick.element, start.element);

state.cellChanged.on((cell) => {
  robots = cell.robots.map((robot, i) => new RobotPanel(state, access, jog, view, robot, i));
  robotsPanel.replaceChildren(jog.element, ...robots.map((panel) => panel.element));
  showChosen();
  access.prune();
});
function showChosen(): void {
  robots.forEach((panel, i) => (panel.element.hidden = i !== robotSwitch.chosen));
  showRobots();
}
function closePreviews(): void {
  for (const panel of robots) panel.closePreview();
}
function showRobots(): void {
  const robot = state.snapshot?.robots[robotSwitch.chosen];
  if (robot) robots[robotSwitch.chosen]?.update(robot);
}
robotSwitch.changed.on(() => {
  closePreviews();
  showChosen();
});
robotSwitch.wanted.on(() => tabs.open(0));
state.display.on(showRobots);
units.changed.on((before) => {
  robots.forEach((panel) => panel.changeUnits(before));
  if (state.snapshot) state.display.emit(state.snapshot);
});

let instance = '';
state.accessChanged.on(() => {
  const token =
    new URLSearchParams(location.hash.slice(1)).get('token') ?? sessionStorage.getItem('token');
  if (state.permission?.tokenHelps && token && !state.permission.control) {
    history.replaceState(null, '', location.pathname);
    void access.authenticate(token);
  }
});
state.snapshotChanged.on((snapshot) => {
  if (instance && instance !== snapshot.instanceId) notify('The daemon has been restarted.');
  instance = snapshot.instanceId;
});

const historyLine = new HistoryLine(state, access);
charts.onMoment = (epoch, time_s) => historyLine.goTo(epoch, time_s);
state.pastChanged.on(() => {
  view.clearTrails();
  closePreviews();
});

const offline = h('div', {class: 'offline-note', role: 'alert', 'data-testid': 'offline'});
state.accessChanged.on(() => {
  const old = state.snapshot ? ' The page shows the last known state.' : '';
  if (!state.connected)
    text(offline, `${state.refusal || 'No connection to the daemon.'} Reconnecting.${old}`);
});
document
  .getElementById('app')!
  .replaceChildren(
    toolbar.element,
    stage,
    scenarioPanel.element,
    h('div', {class: 'lines'}, historyLine.element, new FaultTimeline(state).element),
    h(
      'aside',
      {class: 'side', 'aria-label': 'Panels'},
      access.banner,
      robotSwitch.element,
      tabs.element
    ),
    offline
  );
followTheme();
state.connection.start();

// Player of an exported run, without a daemon: the view of the page, driven by a recording.
import {setModelSource} from '../scene/model_source';
import {makeView} from '../scene/cell_view';
import {State} from '../state';
import {ChartPanel} from '../ui/chart_panel';
import {button, card, Facts, h, notify, text} from '../ui/dom';
import {pictureButtons} from '../ui/pictures';
import {Tabs} from '../ui/tabs';
import {simSeconds} from '../ui/time';
import {LineList} from './line_list';
import type {MotionHeader} from '../../generated/aprsim/v1/motion_pb';
import {indexAt, readRecording, type About, type Recording} from './recording';

const kChart_s = 60; // span of the charts before the current moment
const kRates = [0.1, 0.25, 0.5, 1, 2, 5, 10];

function content(id: string): string {
  return document.getElementById(id)?.textContent ?? '';
}

/** Plays a recording into the view, the charts and the lists. */
class Player {
  private readonly state = new State(); // state of the view
  private readonly charted = new State(); // state of the charts, which receive every moment
  private readonly stage = h('main', {class: 'stage'});
  private readonly view = makeView(this.stage, this.state);
  private readonly charts = new ChartPanel(this.charted);
  private readonly slider = h('input', {
    type: 'range',
    step: '0.001',
    'aria-label': 'Time',
    'data-testid': 'time'
  });
  private readonly clock = h('output', {class: 'clock', 'data-testid': 'clock'});
  private readonly playButton = button('Play', () => this.toggle(), {'data-testid': 'play'});
  private readonly rate = h(
    'select',
    {'aria-label': 'Speed'},
    ...kRates.map((rate) => h('option', {value: rate}, `${rate} ×`))
  );
  private readonly lists: LineList[];
  private now_s: number;
  private moment = -1;
  private scene: MotionHeader | null = null;
  private playing = false;
  private last_ms = 0;

  constructor(
    private readonly recording: Recording,
    about: About
  ) {
    const {moments, header} = recording;
    this.now_s = this.begin_s;
    this.rate.value = '1';
    this.slider.min = String(this.begin_s);
    this.slider.max = String(moments[moments.length - 1]!.time_s);
    this.slider.addEventListener('input', () => this.seek(Number(this.slider.value)));
    const seek = (time_s: number): void => this.seek(time_s);
    const events = new LineList(
      'Events',
      about.lines.filter((l) => l.wire === 'cell'),
      seek
    );
    const wires = new LineList(
      'Wires',
      about.lines.filter((l) => l.wire !== 'cell'),
      seek
    );
    this.lists = [events, wires];
    const facts = new Facts();
    for (const [name, value] of about.facts) facts.set(name, value);
    const tabs = new Tabs(
      [
        {name: 'Events', content: events.element},
        {name: 'Wires', content: wires.element},
        {name: 'Charts', content: this.charts.element},
        {
          name: 'Run',
          content: h(
            'div',
            {class: 'panel'},
            card('Run', facts.element),
            about.notes.length > 0 && card('Notes', ...about.notes.map((n) => h('p', {}, n)))
          )
        }
      ],
      () => this.showLists()
    );
    Object.assign(this.stage, {view: this.view}); // where tests look up what is drawn
    if (this.view.draws)
      this.stage.append(
        h('div', {class: 'layers', role: 'group'}, ...pictureButtons(this.view, 'aprsim-run'))
      );
    this.charts.onMoment = (_, time_s) => this.seek(Math.min(time_s, this.end_s));
    document.title = about.title;
    document.getElementById('app')!.replaceChildren(
      h(
        'header',
        {class: 'toolbar player'},
        h('strong', {}, about.title),
        this.playButton,
        button('−1', () => this.stepBy(-1), {title: 'One picture back (,)'}),
        button('+1', () => this.stepBy(1), {title: 'One picture forward (.)'}),
        this.slider,
        this.clock,
        this.rate
      ),
      this.stage,
      h('aside', {class: 'side', 'aria-label': 'Panels'}, tabs.element)
    );
    document.documentElement.dataset.theme = 'dark';
    this.view.setTheme(true);
    this.turnTo(header);
    addEventListener('keydown', (event) => this.press(event));
    this.seek(this.begin_s);
    requestAnimationFrame((now) => this.loop(now));
  }

  private get begin_s(): number {
    return this.recording.moments[0]!.time_s;
  }
  private get end_s(): number {
    return this.recording.moments[this.recording.moments.length - 1]!.time_s;
  }

  private press(event: KeyboardEvent): void {
    if (event.target instanceof HTMLInputElement && event.target !== this.slider) return;
    const onButton = event.target instanceof Element && event.target.closest('button, select');
    if (event.key === ' ' && onButton) return;
    if (event.key === ' ') this.toggle();
    else if (event.key === '.') this.stepBy(1);
    else if (event.key === ',') this.stepBy(-1);
    else return;
    event.preventDefault();
  }

  private toggle(): void {
    this.playing = !this.playing;
    if (this.playing && this.now_s >= this.end_s) this.seek(this.begin_s);
    text(this.playButton, this.playing ? 'Pause' : 'Play');
  }

  /** Switches to a scene. */
  private turnTo(scene: MotionHeader): void {
    this.scene = scene;
    const models = new Map(
      scene.models.map((file) => [file.name, new TextDecoder().decode(file.content)])
    );
    setModelSource((robot) => Promise.resolve(models.get(robot) ?? ''));
    for (const state of [this.state, this.charted]) {
      state.connection.onUpdate({body: {case: 'appearance', value: scene.appearance!}} as never);
      state.connection.onUpdate({body: {case: 'cell', value: scene.cell!}} as never);
    }
  }

  private stepBy(count: number): void {
    if (this.playing) this.toggle();
    const {moments} = this.recording;
    const at = Math.min(Math.max(this.moment + count, 0), moments.length - 1);
    this.seek(moments[at]!.time_s);
  }

  private loop(now_ms: number): void {
    requestAnimationFrame((next) => this.loop(next));
    const passed_s = ((now_ms - this.last_ms) / 1000) * Number(this.rate.value);
    this.last_ms = now_ms;
    if (!this.playing) return;
    // A page that was hidden does not skip.
    this.seek(Math.min(this.now_s + Math.min(passed_s, Number(this.rate.value)), this.end_s));
    if (this.now_s >= this.end_s) this.toggle();
  }

  private seek(time_s: number): void {
    this.now_s = time_s;
    this.slider.value = String(time_s);
    text(this.clock, simSeconds(time_s));
    const {moments} = this.recording;
    const at = indexAt(moments, time_s);
    if (at !== this.moment) {
      const {header} = moments[at]!;
      const same = header === this.scene;
      if (!same) this.turnTo(header);
      const on = same && at > this.moment && this.moment >= 0 && at - this.moment < 50;
      let first = on
        ? this.moment + 1
        : indexAt(moments, Math.max(this.begin_s, moments[at]!.time_s - kChart_s));
      // Charts show one scene.
      while (moments[first]!.header !== header) ++first;
      // Paths are drawn forward in time only.
      if (!on) this.view.clearTrails();
      this.moment = at;
      for (let i = first; i <= at; ++i)
        this.charted.connection.onUpdate({
          body: {case: 'snapshot', value: moments[i]!.snapshot}
        } as never);
      this.state.connection.onUpdate({
        body: {case: 'snapshot', value: moments[at]!.snapshot}
      } as never);
    }
    this.showLists();
  }

  private showLists(): void {
    for (const list of this.lists) list.update(this.now_s);
  }
}

const about = JSON.parse(content('about')) as About;
readRecording(content('motion').trim()).then(
  (recording) => new Player(recording, about),
  (problem: Error) => notify(problem.message, 'error')
);

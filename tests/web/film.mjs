// Takes the pictures of the README's film: the default cell during its demo, as the page shows it.
// usage: node tests/web/film.mjs FOLDER [SECONDS] [WIDTHxHEIGHT] [PICTURES_PER_S]
//   SECONDS of simulated time. The cell is paused for each picture, so that drawing without a GPU
//   keeps up.
import {spawn, spawnSync} from 'node:child_process';
import {mkdirSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {bin, Daemon, openBrowser, openPage, until} from './harness.mjs';

const kPace = 0.5;
const kFirst_s = 2;
const [folder, seconds = '18', size = '720x450', rate = '4'] = process.argv.slice(2);
const [width, height] = size.split('x').map(Number);

mkdirSync(folder, {recursive: true});
const daemon = await Daemon.start(['--speed', String(kPace)]);
const browser = await openBrowser();
const page = await openPage(browser, daemon, {
  query: '?quality=fine',
  viewport: {width, height},
  colorScheme: 'light',
  bypassCSP: true
});
// The view alone, over the whole window.
await page.addStyleTag({
  content: `#app > :not(main.stage) { display: none !important }
    main.stage { position: fixed !important; inset: 0; width: 100vw; height: 100vh; z-index: 99 }
    .stage > :not(canvas) { display: none !important }`
});
await page.evaluate(() => {
  const {view} = document.querySelector('main.stage');
  view.atHome = false;
  view.setLayer('curtain', false);
  const target = view.controls.target.set(0, -0.55, 1.05);
  view.camera.position.set(1.35, -3.0, 2.3);
  view.camera.lookAt(target);
  view.controls.update();
  window.dispatchEvent(new Event('resize'));
});
const ports = join(daemon.directory, 'ports.json');
/** Takes steps and pauses; the step after them. */
function run(steps) {
  const words = ['--ports-file', ports, 'run', '--steps', String(steps), '--json'];
  const {status, stdout, stderr} = spawnSync(join(bin, 'aprsim'), words);
  if (status !== 0) throw new Error(`aprsim run: ${stderr}`);
  return JSON.parse(stdout).step;
}
const demo = spawn(join(bin, 'aprsim'), ['--ports-file', ports, 'demo'], {stdio: 'ignore'});
try {
  // The page's own picture of a step, without waiting for the browser to show it.
  const picture = (step) =>
    page.evaluate((step) => {
      const {view} = document.querySelector('main.stage');
      if (Number(view.taken?.step ?? -1) !== step) return null;
      view.renderer.shadowMap.needsUpdate = true;
      view.render();
      return view.renderer.domElement.toDataURL('image/png').split(',')[1];
    }, step);
  const times = [];
  let step = run(1000 * kFirst_s);
  for (let k = 0; k < Number(seconds) * Number(rate); ++k) {
    const png = await until(`step ${step} to arrive`, () => picture(step), 300000);
    const file = `${String(k).padStart(4, '0')}.png`;
    writeFileSync(join(folder, file), Buffer.from(png, 'base64'));
    times.push({file, sim_time_s: step / 1000});
    step = run(Math.round(1000 / Number(rate)));
  }
  writeFileSync(join(folder, 'times.json'), JSON.stringify(times));
} finally {
  demo.kill();
  await browser.close();
  await daemon.stop();
}

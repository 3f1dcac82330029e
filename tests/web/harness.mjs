// The real daemon, a real browser, and clients of the other wires, for the tests of the page.
import {spawn} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {connect} from 'node:net';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {chromium} from 'playwright-core';

const here = dirname(fileURLToPath(import.meta.url));
export const bin = process.env.APRSIM_BIN_DIR ?? join(here, '../../build/release/bin');
const browserProgram = process.env.CHROMIUM ?? '/usr/bin/chromium';

// Ends tests that hang; a busy machine is slow, which is no failure.
const kDeadline_ms = 300000;

/** Waits until `look` gives something true. */
export async function until(what, look, deadline_ms = kDeadline_ms) {
  const end = Date.now() + deadline_ms;
  for (let last; ; ) {
    try {
      const found = await look();
      if (found) return found;
    } catch (problem) {
      last = problem;
    }
    if (Date.now() > end)
      throw new Error(`waited in vain: ${what}${last ? ` (${last.message})` : ''}`);
    await new Promise((go) => setTimeout(go, 30));
  }
}

const running = new Set();
const plainBrowsers = new WeakSet();

/** Ends daemons that a failed test has left. */
export async function stopAll() {
  for (const daemon of running) await daemon.stop();
}

export class Daemon {
  static async start(args = [], ports = null) {
    const daemon = new Daemon();
    running.add(daemon);
    daemon.directory = mkdtempSync(join(tmpdir(), 'aprsim-web-'));
    const file = (daemon.portsFile = join(daemon.directory, 'ports.json'));
    const fixed = ports ? ['--set', `web.port=${ports.web}`] : [];
    daemon.process = spawn(
      join(bin, 'aprsimd'),
      [...(ports ? [] : ['--any-port']), '--ports-file', file, ...fixed, ...args],
      {stdio: ['ignore', 'ignore', 'pipe']}
    );
    daemon.log = '';
    daemon.process.stderr.on('data', (text) => (daemon.log += text));
    await until('the daemon to listen', () => {
      if (daemon.process.exitCode !== null) throw new Error(daemon.log);
      return existsSync(file);
    });
    daemon.ports = JSON.parse(readFileSync(file, 'utf8'));
    return daemon;
  }
  get url() {
    return `http://127.0.0.1:${this.ports.web}/`;
  }
  async stop() {
    running.delete(this);
    if (this.process.exitCode === null) {
      const ended = new Promise((end) => this.process.once('exit', end));
      this.process.kill('SIGTERM');
      await ended;
    }
    rmSync(this.directory, {recursive: true, force: true});
  }
}

export function openBrowser() {
  return chromium.launch({
    executablePath: browserProgram,
    headless: true,
    args: [
      '--no-sandbox',
      '--disable-dev-shm-usage',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--ignore-gpu-blocklist',
      '--disable-gpu-rasterization'
    ]
  });
}

/** A browser without WebGL, which needs far less time than one that renders in software. */
export async function openPlainBrowser() {
  const browser = await chromium.launch({
    executablePath: browserProgram,
    headless: true,
    args: ['--no-sandbox', '--disable-dev-shm-usage', '--disable-gpu', '--disable-3d-apis']
  });
  plainBrowsers.add(browser);
  return browser;
}

/** Runs inside the page. */
function refuseWebGl() {
  const {prototype} = HTMLCanvasElement;
  const {getContext} = prototype;
  prototype.getContext = function (kind, ...rest) {
    return kind.startsWith('webgl') ? null : getContext.call(this, kind, ...rest);
  };
}

/** Opens the daemon's page and waits for its first picture, if the browser can draw any. `webgl: false`
 * keeps it from drawing. Errors and warnings of the console are collected in `page.complaints`. */
export async function openPage(browser, daemon, options = {}) {
  const {query = '', webgl = true, ...context} = options;
  const frames = webgl && !plainBrowsers.has(browser) ? 'drawn' : 'none';
  const page = await (
    await browser.newContext({
      viewport: {width: 1200, height: 800},
      colorScheme: 'dark',
      ...context
    })
  ).newPage();
  if (!webgl) await page.addInitScript(refuseWebGl);
  page.setDefaultTimeout(kDeadline_ms); // software rendering on a busy machine
  page.complaints = [];
  page.on('console', (message) => {
    // Software rendering has its own remarks on performance.
    if (
      ['error', 'warning'].includes(message.type()) &&
      !/GL Driver Message|WebGL|swiftshader/i.test(message.text())
    )
      page.complaints.push(message.text());
  });
  page.on('pageerror', (error) => page.complaints.push(String(error)));
  await page.goto(daemon.url + query);
  await page.waitForSelector(`main[data-frames=${frames}]`, {timeout: kDeadline_ms});
  return page;
}

/** Speaks CRCL as a controller does: one document after another, then GetStatus until it is done. */
export class CrclClient {
  static async open(port) {
    const client = new CrclClient();
    client.socket = connect(port, '127.0.0.1');
    client.received = '';
    client.id = 0;
    client.socket.setNoDelay(true);
    client.socket.on('data', (data) => (client.received += data));
    await new Promise((ready, failed) =>
      client.socket.once('connect', ready).once('error', failed)
    );
    return client;
  }
  send(type, content = '') {
    this.id += 1;
    this.socket.write(
      `<?xml version="1.0" encoding="UTF-8"?><CRCLCommandInstance xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><CRCLCommand xsi:type="${type}"><CommandID>${this.id}</CommandID>${content}</CRCLCommand></CRCLCommandInstance>`
    );
    return this.id;
  }
  async status() {
    this.received = '';
    this.send('GetStatusType');
    this.id -= 1;
    await until('a status', () => this.received.includes('</CRCLStatus>'));
    return this.received;
  }
  async run(type, content = '') {
    const id = this.send(type, content);
    const end = await until(`${type} to end`, async () => {
      const status = await this.status();
      return (
        status.includes(`<CommandID>${id}</CommandID>`) &&
        /CRCL_(Done|Error)/.test(status) &&
        status
      );
    });
    if (end.includes('CRCL_Error')) throw new Error(end);
    return end;
  }
  /** At the robot's own speed, or at one in degrees a second. */
  moveJoints(degrees, speed) {
    const details = speed ? `<JointSpeed>${speed}</JointSpeed>` : '';
    return this.run(
      'ActuateJointsType',
      degrees
        .map(
          (position, i) =>
            `<ActuateJoint><JointNumber>${i + 1}</JointNumber><JointPosition>${position}</JointPosition><JointDetails xsi:type="JointSpeedAccelType">${details}</JointDetails></ActuateJoint>`
        )
        .join('')
    );
  }
  close() {
    this.socket.destroy();
  }
}

/** Writes one holding register of the conveyor's PLC. */
export async function writeRegister(port, address, value) {
  const socket = connect(port, '127.0.0.1');
  const answer = new Promise((done, failed) => socket.once('data', done).once('error', failed));
  const request = Buffer.from([
    0,
    9,
    0,
    0,
    0,
    6,
    1,
    6,
    address >> 8,
    address & 255,
    value >> 8,
    value & 255
  ]);
  socket.write(request);
  const reply = await answer;
  socket.destroy();
  if (!reply.equals(request)) throw new Error(`the PLC answered ${reply.toString('hex')}`);
}

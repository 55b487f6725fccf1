// A headless Chromium over its debugging pipe: no package is needed. Messages are JSON that end with a zero byte.
'use strict';
const {spawn} = require('node:child_process'), fs = require('node:fs'), os = require('node:os'), path = require('node:path');

class Browser {
  /** browser: the command; flags: more of them. */
  constructor(browser, flags = []) {
    this.folder = fs.mkdtempSync(path.join(os.tmpdir(), 'lab-'));
    this.process = spawn(browser, ['--headless=new', '--no-sandbox', '--disable-gpu', '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader', '--remote-debugging-pipe', `--user-data-dir=${this.folder}`, '--no-first-run', '--hide-scrollbars',
      ...flags, 'about:blank'], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
    [this.to, this.from] = [this.process.stdio[3], this.process.stdio[4]];
    this.waiting = new Map();
    this.count = 0;
    this.said = [];  // exceptions and errors of the page
    this.asked = [];  // addresses that it wanted
    let rest = '';
    this.from.on('data', data => {
      const parts = (rest + data).split('\0');
      rest = parts.pop();
      for (const part of parts) this.hear(JSON.parse(part));
    });
  }

  hear(message) {
    if (message.id) {
      const {resolve, reject} = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (message.error) reject(new Error(message.error.message));
      else resolve(message.result);
    }
    const {method, params} = message;
    if (method === 'Runtime.exceptionThrown') this.said.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    if (method === 'Log.entryAdded' && params.entry.level === 'error') this.said.push(params.entry.text);
    if (method === 'Network.requestWillBeSent') this.asked.push(params.request.url);
  }

  send(method, params = {}) {
    const id = ++this.count;
    this.to.write(JSON.stringify({id, method, params, sessionId: this.session}) + '\0');
    return new Promise((resolve, reject) => this.waiting.set(id, {resolve, reject}));
  }

  async open(url, width, height, dark = false) {
    if (!this.session) {
      const {targetInfos} = await this.send('Target.getTargets');
      const {sessionId} = await this.send('Target.attachToTarget', {targetId: targetInfos.find(one => one.type === 'page').targetId, flatten: true});
      this.session = sessionId;
      for (const domain of ['Page', 'Runtime', 'Log', 'Network']) await this.send(domain + '.enable');
    }
    await this.send('Emulation.setDeviceMetricsOverride', {width, height, deviceScaleFactor: 1, mobile: width < 600});
    await this.send('Emulation.setTouchEmulationEnabled', {enabled: false});
    await this.send('Emulation.setEmulatedMedia', {features: [{name: 'prefers-color-scheme', value: dark ? 'dark' : 'light'}]});
    await this.send('Page.navigate', {url: 'about:blank'});  // an address that differs after # alone opens nothing new
    await this.send('Page.navigate', {url});
    await this.until('document.documentElement.dataset.ready');
  }

  async eval(expression) {
    const {result, exceptionDetails} = await this.send('Runtime.evaluate', {expression, awaitPromise: true, returnByValue: true});
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  async until(expression, seconds = 120) {
    for (const end = Date.now() + 1000 * seconds; Date.now() < end;) {
      if (await this.eval(expression).catch(() => false)) return;
      await sleep(50);
    }
    throw new Error(`waited ${seconds} s for ${expression}; the page says: ${await this.eval('document.getElementById("problem")?.textContent')} ${this.said}`);
  }

  mouse(type, x, y, buttons = 1) {
    return this.send('Input.dispatchMouseEvent', {type, x, y, button: type === 'mouseMoved' && !buttons ? 'none' : 'left', buttons, clickCount: type === 'mouseMoved' ? 0 : 1});
  }

  touch(type, points) { return this.send('Input.dispatchTouchEvent', {type, touchPoints: points.map(([x, y]) => ({x, y}))}); }

  async picture(file, whole = false) {
    const {data} = await this.send('Page.captureScreenshot', {format: 'png', captureBeyondViewport: whole});
    fs.writeFileSync(file, Buffer.from(data, 'base64'));
  }

  async close() {
    this.session = undefined;
    await this.send('Browser.close').catch(() => {});
    await new Promise(resolve => this.process.exitCode === null ? this.process.once('exit', resolve) : resolve());
    fs.rmSync(this.folder, {recursive: true, force: true, maxRetries: 5, retryDelay: 200});
  }
}

const sleep = ms => new Promise(resolve => setTimeout(resolve, ms));
module.exports = {Browser, sleep};

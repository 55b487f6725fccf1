// The npm package in a browser, by its own address without a bundler: node module_test.js CHROMIUM FOLDER
'use strict';
const assert = require('node:assert'), fs = require('node:fs'), http = require('node:http'), path = require('node:path');
const {Browser} = require('./browser.js'), [chromium, folder] = process.argv.slice(2);

const page = `<!doctype html><title>A spring</title><link rel="icon" href="data:,"><script type="module">
import {load, ElastinError} from './${require(path.resolve(folder, 'package.json')).exports['.'].default}';
const elastin = await load();
const body = elastin.body({positions: [0, 0, 0, 0, 0, -0.1], connections: [0, 1], masses: [1, 0.5]});
const tissue = body.simulate('uniform', {youngs_modulus: 1e3}, {stepper: 'backward_euler', parameters: {constant: 200}});
tissue.add('gravity', {acceleration_z: -9.81});
tissue.fix(0);
const settled = tissue.settle().unstable;
const pushing = body.simulate('uniform', {youngs_modulus: 1e3}, {parameters: {constant: -200}});
const pushed = pushing.settle().unstable;
let refused = false;
try { tissue.add('gravitas'); } catch (error) { refused = error instanceof ElastinError; }
window.answer = {refused, settled, pushed, z: tissue.positions[5]};
document.documentElement.dataset.ready = 'yes';
</script>`;
const types = {'.mjs': 'text/javascript', '.js': 'text/javascript', '.wasm': 'application/wasm'};
const server = http.createServer(({url}, answer) => {
  const file = path.join(folder, url), type = types[path.extname(file)];
  answer.writeHead(url === '/' || type ? 200 : 404, {'content-type': type ?? 'text/html'});
  answer.end(url === '/' ? page : type && fs.readFileSync(file));
});

server.listen(0, async () => {
  const browser = new Browser(chromium);
  process.on('exit', () => browser.process.kill());
  await browser.open(`http://localhost:${server.address().port}/`, 800, 600);
  const {refused, settled, pushed, z} = await browser.eval('window.answer');
  assert(refused && !settled && pushed);
  assert(Math.abs(z + 0.1 + 0.5 * 9.81 / 200) < 1e-9, `${z}`);
  assert.deepStrictEqual(browser.said, []);
  process.exit(0);
});

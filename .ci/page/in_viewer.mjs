// Follows links of a page into the web viewer beside it: in_viewer.mjs ADDRESS PICTURES
// ADDRESS is that of a page that `scanbench report RUN --with-viewer --serve` serves. Each of the first links has to lead to
// its scan, in a tab that is drawn: with points, boxes and the colours of right and wrong.
import { mkdirSync } from 'node:fs';
import { chromium } from 'playwright-core';

const [address, pictures] = process.argv.slice(2);
const PATIENCE_S = 90, N_LINKS = 2, LEAST_COLOURS = 200;
const arguments_ = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'];
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: arguments_ });
const fail = async (problem) => { console.error(problem); await browser.close(); process.exit(1); };
mkdirSync(pictures, { recursive: true });
const context = await browser.newContext({ viewport: { width: 1400, height: 800 } });
const counter = await context.newPage();
const page = await context.newPage();
await page.goto(address);
const links = page.locator('a[target=scanbench-viewer]');
if (await links.count() < N_LINKS) await fail(`${address} has ${await links.count()} links into the viewer`);
let viewer = null;
context.on('request', it => { if (!/^(data|blob):/.test(it.url()) && !it.url().startsWith(address)) console.log(`asked for: ${it.url()}`); });
for (let n = 0; n < N_LINKS; n++) {
    const scan = (await links.nth(n).getAttribute('href')).split('scan=')[1];
    if (viewer) await links.nth(n).click();
    else [viewer] = await Promise.all([context.waitForEvent('page'), links.nth(n).click()]);
    const deadline = Date.now() + PATIENCE_S * 1000;
    while (await viewer.title() !== `scan ${scan}: scanbench`) {
        if (Date.now() > deadline) await fail(`scan ${scan} is not shown after ${PATIENCE_S} s: ${await viewer.locator('#said').textContent()}`);
        await viewer.waitForTimeout(500);
    }
    // All layers, by a processor that draws for a graphics card.
    await viewer.waitForTimeout(25000);
    const png = await viewer.screenshot({ path: `${pictures}/in-viewer-${n}.png`, timeout: 60000 });
    const n_colours = await counter.evaluate(async (data) => {
        const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
        const canvas = new OffscreenCanvas(image.width, image.height).getContext('2d');
        canvas.drawImage(image, 0, 0);
        const pixels = new Uint32Array(canvas.getImageData(0, 0, image.width, image.height).data.buffer);
        return new Set(pixels).size;
    }, png.toString('base64'));
    if (n_colours < LEAST_COLOURS) await fail(`scan ${scan}: a picture of ${n_colours} colours alone`);
    console.log(`scan ${scan}: shown, ${n_colours} colours`);
}
await browser.close();

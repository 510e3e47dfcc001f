// Takes two pictures of a report page and puts them side by side: its beginning in light, the worst mistakes in dark.
import { pathToFileURL } from 'node:url';
import { browser } from './reader.mjs';

// Pictures are four fifths as large.
const SIZE = { width: 1025, height: 893 }, SCALE = 0.8;
const VIEWS = [{ colorScheme: 'light', at: null }, { colorScheme: 'dark', at: '#worst' }];

const [file, picture] = process.argv.slice(2);
let images = '';
for (const { colorScheme, at } of VIEWS) {
    const page = await browser.newPage({ viewport: SIZE, deviceScaleFactor: SCALE, colorScheme });
    await page.goto(pathToFileURL(file).href);
    if (at) await page.locator(at).evaluate(it => it.scrollIntoView({ behavior: 'instant' }));
    images += `<img alt="" src="data:image/png;base64,${(await page.screenshot()).toString('base64')}">`;
}
const both = { width: VIEWS.length * SCALE * SIZE.width, height: Math.floor(SCALE * SIZE.height) };
const page = await browser.newPage({ viewport: both });
await page.setContent(`<style>body { margin: 0; display: flex }</style>${images}`);
await page.screenshot({ path: picture });
await browser.close();

// Takes two pictures of a report page and puts them side by side: its beginning in light, the worst mistakes in dark.
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

// Pictures are four fifths as large.
const SIZE = { width: 1025, height: 893 }, SCALE = 0.8;
const VIEWS = [{ colorScheme: 'light', at: null }, { colorScheme: 'dark', at: '#worst' }];

const [file, picture] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--disable-gpu'] });
const shots = [];
for (const { colorScheme, at } of VIEWS) {
    const page = await browser.newPage({ viewport: SIZE, deviceScaleFactor: SCALE, colorScheme });
    await page.goto(pathToFileURL(file).href);
    if (at) {
        await page.locator(at).evaluate(it => it.scrollIntoView({ behavior: 'instant' }));
    }
    shots.push((await page.screenshot()).toString('base64'));
    await page.close();
}
const both = await browser.newPage({ viewport: { width: VIEWS.length * SCALE * SIZE.width, height: Math.floor(SCALE * SIZE.height) } });
const images = shots.map(it => `<img alt="" src="data:image/png;base64,${it}">`).join('');
await both.setContent(`<style>body { margin: 0; display: flex }</style>${images}`);
await both.screenshot({ path: picture });
await browser.close();

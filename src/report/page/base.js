'use strict';
// What every part of the page uses: the data, elements, numbers with units, colours, the tooltip, and
// the instant that the parts show together.

const runs = JSON.parse(document.getElementById('data').textContent).runs;
const isComparison = runs.length > 1;
const byId = (id) => document.getElementById(id);

/** An element with attributes and children; text is never taken for markup. */
function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

// The name space of SVG, taken from the parser so that the page holds no address at all.
const svgSpace = (() => {
  const box = document.createElement('div');
  box.innerHTML = '<svg></svg>';
  return box.firstChild.namespaceURI;
})();

function svg(tag, attributes = {}, ...children) {
  const node = document.createElementNS(svgSpace, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

/** Three to four significant digits, without an exponent where it can be helped. */
function short(value) {
  if (!isNumber(value)) return '–';
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (size >= 1e10 || size < 1e-4) return value.toExponential(2);
  if (size >= 1000) return Math.round(value).toLocaleString('en-GB').replace(/,/g, '\u202f');
  return String(Number(value.toPrecision(size >= 100 ? 4 : 3)));
}

const withUnit = (value, unit) => (isNumber(value) ? `${short(value)} ${unit}` : '–');

/** The number as `evaluate` prints it: nine significant digits. */
const exact = (value) => (isNumber(value) ? String(Number(value.toPrecision(9))) : '–');

function bytesText(bytes) {
  if (!isNumber(bytes)) return '–';
  const units = ['B', 'KiB', 'MiB', 'GiB'];
  let k = 0;
  for (; bytes >= 1024 && k < units.length - 1; ++k) bytes /= 1024;
  return `${short(bytes)} ${units[k]}`;
}

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const runColour = (k) => (k === 0 ? 'a' : 'b');
const runName = (k) => (isComparison ? `${'AB'[k]}: ${runs[k].name}` : 'estimate');

// Weights from 0 to 1. The second set is told apart by eyes that do not tell red from green.
const palettes = {
  'green-red': { stops: [[215, 40, 30], [245, 200, 60], [40, 175, 80]], on: [90, 170, 255], off: [255, 120, 205] },
  'blue-orange': { stops: [[230, 110, 10], [235, 225, 200], [40, 130, 235]], on: [250, 235, 90], off: [180, 120, 255] },
};
let palette = palettes['green-red'];

function mix(stops, share) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const k = Math.min(Math.floor(at), stops.length - 2);
  const channel = (i) => Math.round(stops[k][i] + (at - k) * (stops[k + 1][i] - stops[k][i]));
  return `rgb(${channel(0)}, ${channel(1)}, ${channel(2)})`;
}
const weightColour = (w) => (isNumber(w) ? mix(palette.stops, w) : '#9aa4ad');
const rgb = (c) => `rgb(${c.join(', ')})`;

// Everything that is drawn, to be drawn anew when colours or widths change.
const drawings = [];
function draw(host, paint) {
  drawings.push(paint);
  let width = 0;
  new ResizeObserver(() => {
    if (Math.abs(host.clientWidth - width) < 1) return;
    width = host.clientWidth;
    paint();
  }).observe(host);
}
const redraw = () => drawings.forEach((paint) => paint());

// The instant shown: seconds after the first frame.
let instant_s = 0;
const instantListeners = [];
const onInstant = (listener) => instantListeners.push(listener);
function setInstant(t_s) {
  instant_s = t_s;
  instantListeners.forEach((listener) => listener());
}

function showTip(text, event) {
  const tip = byId('tip');
  tip.textContent = text;
  tip.hidden = false;
  const box = tip.getBoundingClientRect();
  const left = event.clientX + 14 + box.width > innerWidth ? event.clientX - box.width - 10 : event.clientX + 14;
  const top = event.clientY + 14 + box.height > innerHeight ? event.clientY - box.height - 10 : event.clientY + 14;
  tip.style.left = `${Math.max(4, left)}px`;
  tip.style.top = `${Math.max(4, top)}px`;
}
const hideTip = () => { byId('tip').hidden = true; };

/** Shows what `words(event)` says while the pointer is over the node; nothing for an empty answer. */
function hover(node, words) {
  const show = (event) => {
    const text = words(event);
    if (text) showTip(text, event); else hideTip();
  };
  node.addEventListener('pointermove', show);
  node.addEventListener('pointerdown', show);
  node.addEventListener('pointerleave', hideTip);
}

/** [{name, colour, shape}]: shape is '', 'dash', 'dots', 'box' or 'ring'; words alone have no colour. */
function legend(host, entries) {
  host.replaceChildren(...entries.map(({ name, colour: c, shape = '' }) => {
    const mark = el('i', { class: shape });
    mark.style.color = c;
    return el('span', {}, ...(c ? [mark] : []), name);
  }));
}

const empty = (words) => el('div', { class: 'empty' }, words);

/** A table of texts; cells may be elements. */
function table(head, rows) {
  const row = (cells, tag) => el('tr', {}, ...cells.map((cell) => el(tag, {}, cell)));
  const body = el('tbody', {}, ...rows.map((cells) => row(cells, 'td')));
  return el('div', { class: 'scroll' }, el('table', {}, el('thead', {}, row(head, 'th')), body));
}

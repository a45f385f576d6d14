// Puts the parts together.

summary();
pathViews();
errorView();
moments();
histograms();
featureView();
temporalView();
streams();
tables();

byId('palette').addEventListener('change', (event) => {
  palette = palettes[event.target.value];
  redraw();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
addEventListener('scroll', hideTip, { passive: true });
redraw();

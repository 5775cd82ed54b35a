// Draws the plots of a report where the page has their library. Everything else on the page needs no script.
(() => {
  "use strict";

  // Colours of text, axes and grids are the page's (report.css), so that plots follow its theme and print; these are for plots
  // that are saved.
  const config = {
    background: null,
    font: "system-ui, sans-serif",
    view: { stroke: null },
    axis: {
      domainColor: "#888", tickColor: "#888", gridColor: "#ddd", labelColor: "#444", titleColor: "#444",
      titleFontWeight: "normal", labelFontSize: 10.5, titleFontSize: 11.5, titlePadding: 6, tickSize: 4, gridOpacity: 0.8,
    },
    header: { labelFontSize: 12, labelFontWeight: 600, labelColor: "#222", labelPadding: 6 },
    legend: { orient: "bottom", labelFontSize: 10.5, symbolSize: 70, labelColor: "#444", labelLimit: 260, columnPadding: 14, title: null },
    bar: { cornerRadiusEnd: 1.5 },
  };

  // Panels as wide as they fit, in as many columns.
  const fitted = (spec, width) => {
    const { least_width, most_width, gap, legend_entry, labels } = spec.usermeta.report;
    const longest = Math.max(0, ...spec.data.values.map((row) => (labels ? row[labels].length : 0)));
    const beside = spec.usermeta.report.beside + Math.min(220, 6.2 * longest);
    const panels = new Set(spec.data.values.map((row) => row[spec.facet.field])).size;
    const fit = Math.floor((width - beside + gap) / (least_width + gap));
    const columns = Math.max(1, Math.min(panels, fit));
    const panel = Math.floor((width - beside - (columns - 1) * gap) / columns);
    const legend = { columns: Math.max(1, Math.floor(width / (legend_entry ?? 110))) };
    return {
      ...spec, columns, spec: { ...spec.spec, width: Math.max(120, Math.min(panel, most_width)) },
      config: { ...config, legend: { ...config.legend, ...legend } },
    };
  };

  const draw = (figure) => {
    const spec = JSON.parse(figure.querySelector("script").textContent);
    const place = figure.querySelector(".drawing");
    return vegaEmbed(place, fitted(spec, place.clientWidth), {
      renderer: "svg", actions: { export: true, source: true, compiled: false, editor: false },
      downloadFileName: figure.id,
      logLevel: vega.Error,  // a panel may lack marks of a kind, such as errors: Vega warns of that
    }).then(() => figure.classList.add("drawn"));
  };

  const draw_all = () => Promise.all([...document.querySelectorAll("figure.plot")].map(draw));

  const offer_numbers = () => {
    const button = document.getElementById("save-numbers");
    button.hidden = false;
    button.addEventListener("click", () => {
      const numbers = document.getElementById("numbers").textContent;
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([numbers], { type: "application/json" }));
      link.download = "accel-trace.json";
      link.click();
    });
  };

  offer_numbers();
  if (typeof vegaEmbed === "undefined") return;
  document.documentElement.classList.add("with-plots");
  let width = document.documentElement.clientWidth, waiting = 0;
  window.addEventListener("resize", () => {
    if (document.documentElement.clientWidth === width) return;
    width = document.documentElement.clientWidth;
    clearTimeout(waiting);
    waiting = setTimeout(draw_all, 150);
  });
  draw_all().then(() => document.documentElement.classList.add("all-drawn"));
})();

// What every picture on a canvas is made of: the page's colours, lines, circles and aircraft.
const rssCanvas = (() => {
  function colours() {
    const style = getComputedStyle(document.documentElement);
    const names = ["paper", "panel", "ink", "muted", "line", "frame", "blue", "red", "orange", "ring"];
    return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  }

  /** The canvas cleared, in CSS pixels. */
  function prepared(canvas, ground) {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.globalAlpha = 1;
    pen.setLineDash([]);
    pen.fillStyle = ground;
    pen.fillRect(0, 0, width, height);
    pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    return { pen, width, height };
  }

  function stroke(pen, points, colour, width, dash = [], alpha = 1) {
    if (points.length < 2) return;
    pen.beginPath();
    points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.setLineDash(dash);
    pen.globalAlpha = alpha;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.lineJoin = "round";
    pen.stroke();
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  function circle(pen, [x, y], radius, { line, width = 1, dash = [], fill, alpha = 1, inner = 0 }) {
    if (!(radius > 0)) return;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    if (fill) {
      if (inner > 0) pen.arc(x, y, inner, 0, 2 * Math.PI, true);
      pen.globalAlpha = alpha;
      pen.fillStyle = fill;
      pen.fill();
      pen.globalAlpha = 1;
    }
    if (line) {
      pen.setLineDash(dash);
      pen.strokeStyle = line;
      pen.lineWidth = width;
      pen.stroke();
      pen.setLineDash([]);
    }
  }

  /** A dart that points along `heading` (pixels), or a disc without one. */
  function dart(pen, [x, y], heading, colour, paper, size = 1) {
    const length = Math.hypot(heading[0], heading[1]);
    if (length < 1e-6) return circle(pen, [x, y], 5, { fill: colour, line: paper });
    const [c, s] = [heading[0] / length * size, heading[1] / length * size];
    pen.beginPath();
    [[10, 0], [-7, 6], [-4, 0], [-7, -6]].forEach(([a, b], k) => {
      const [px, py] = [x + a * c - b * s, y + a * s + b * c];
      if (k) pen.lineTo(px, py); else pen.moveTo(px, py);
    });
    pen.closePath();
    pen.fillStyle = colour;
    pen.strokeStyle = paper;
    pen.lineWidth = 1.2;
    pen.fill();
    pen.stroke();
  }

  return { colours, prepared, stroke, circle, dart };
})();

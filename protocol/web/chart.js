// A line of the last minute, drawn small; and the number beside it.

const COUNT = 240; // four values per second

export class Chart {
  constructor(name, print) {
    this.text = document.getElementById(name);
    this.canvas = document.getElementById(name + '-chart');
    this.print = print;
    this.values = [];
  }

  add(value) {
    if (!Number.isFinite(value)) return;
    this.values.push(value);
    if (this.values.length > COUNT) this.values.shift();
    this.text.textContent = this.print(value);
    const { width, height } = this.canvas, context = this.canvas.getContext('2d'), most = Math.max(...this.values) || 1;
    context.clearRect(0, 0, width, height);
    context.strokeStyle = '#6cf';
    context.beginPath();
    this.values.forEach((v, i) => context.lineTo((i + COUNT - this.values.length) / (COUNT - 1) * width, height - 1 - v / most * (height - 2)));
    context.stroke();
  }
}

// How fast pictures follow each other, and what to do where drawing is slow: the core works meanwhile, and moving bodies are
// drawn with fewer pixels. Nothing of the page is touched here.
'use strict';

class Pace {
  constructor() {
    this.interval = 1 / 60;  // [s] from picture to picture, on average
    this.core = 0;  // [s] of it that the core took
    this.sharpness = 1;  // share of the screen's pixels along a side
    this.count = 0;
    this.quick = 0;  // pictures in a row that came in time
    this.regretted = false;  // a sharper picture was too slow before
  }

  /** Between two pictures lay an interval [s], and the core had its share of it [s]. */
  note(interval, core) {
    const share = interval > 0.2 ? 0.5 : 0.2;
    this.interval += share * (Math.min(interval, 1) - this.interval);
    this.core += share * (Math.min(core, interval, 1) - this.core);
    this.quick = interval < 0.02 ? this.quick + 1 : 0;
    if ((++this.count % 6 === 0 || interval > 0.2) && this.drawing > 0.0185 && this.sharpness > 0.4) {
      this.regretted ||= this.raised;
      this.sharpness = Math.max(0.4, 0.75 * this.sharpness);
      this.quick = 0;
    } else if (this.quick >= 60 && this.sharpness < 1 && !this.regretted) {
      this.sharpness = Math.min(1, this.sharpness / 0.75);
      this.raised = true;
      this.quick = 0;
    }
  }

  /** [s] of a picture that are not the core's. */
  get drawing() { return Math.max(0, this.interval - this.core); }

  /** It is drawing that keeps pictures below 25 a second. */
  get slow() { return this.drawing > 0.04; }

  /** [s] that stepping may take of the next picture: most of one at 60 a second, or of the time that drawing takes in addition. */
  get budget() { return Math.min(0.1, Math.max(0.012, 0.7 * this.drawing)); }
}

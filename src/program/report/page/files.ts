/** Gives the reader a file. */
export function save(bytes: Blob, name: string): void {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(bytes), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

const kinds = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];

/** Records a canvas as a video until it is told to stop. */
export class Film {
  private recorder: MediaRecorder;
  private parts: Blob[] = [];

  constructor(canvas: HTMLCanvasElement, name: string) {
    const mimeType = kinds.find((kind) => MediaRecorder.isTypeSupported(kind));
    this.recorder = new MediaRecorder(canvas.captureStream(30), { mimeType, videoBitsPerSecond: 8e6 });
    this.recorder.ondataavailable = ({ data }) => this.parts.push(data);
    this.recorder.onstop = () => save(new Blob(this.parts, { type: this.recorder.mimeType }), `${name}.${this.recorder.mimeType.includes("mp4") ? "mp4" : "webm"}`);
    this.recorder.start(1000);
  }
  stop(): void { if (this.recorder.state !== "inactive") this.recorder.stop(); }
}

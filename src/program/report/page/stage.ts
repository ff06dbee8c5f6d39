import { Box3, PerspectiveCamera, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

/** Directions from which one looks, as parts of what is in front, to the right and above. */
export const looks = { front: [1, 0, 0], side: [0, 1, 0], top: [1e-3, 0, 1], isometric: [1, 1, 1], corner: [1, 0.55, 0.4] };
export type Look = keyof typeof looks;

/** The canvas, the camera and its controls, which outlive the views of one run. */
export class Stage {
  readonly renderer: WebGLRenderer;
  readonly camera = new PerspectiveCamera(35, 1, 0.01, 1000);
  controls: OrbitControls;
  resized: (width: number, height: number) => void = () => {};
  private box = new Box3(); // all that was to be seen since the picture was fitted
  private isHandled = false; // a hand has turned or moved the picture since then

  constructor(readonly host: HTMLElement, private changed: () => void) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    host.prepend(this.renderer.domElement);
    this.controls = this.makeControls();
    new ResizeObserver(() => { this.resize(); changed(); }).observe(host);
  }

  /** Sets the direction around which a hand turns the picture. OrbitControls read it only when they are made. */
  setUp(up: Vector3): void {
    if (this.camera.up.equals(up)) return;
    this.camera.up.copy(up);
    this.controls.dispose();
    this.controls = this.makeControls();
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.renderer.domElement);
    let isHeld = false; // a click alone changes nothing
    controls.addEventListener("start", () => (isHeld = true));
    controls.addEventListener("end", () => (isHeld = false));
    controls.addEventListener("change", () => { this.isHandled ||= isHeld; this.changed(); });
    return controls;
  }

  resize(): void {
    const width = this.host.clientWidth, height = this.host.clientHeight, ratio = this.renderer.getPixelRatio();
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.resized(width * ratio, height * ratio);
    if (!this.isHandled && !this.box.isEmpty()) this.aim();
  }

  /** Fits the picture to a box, seen from a side, or as now. */
  fit(box: Box3, look?: Look): void {
    const { up } = this.camera, sideways = Math.abs(up.x) < 0.7 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
    const right = sideways.addScaledVector(up, -sideways.dot(up)).normalize(), front = right.clone().cross(up);
    this.box.copy(box);
    this.isHandled = false;
    if (!look) return this.aim();
    const [forward, aside, above] = looks[look];
    this.aim(front.multiplyScalar(forward).addScaledVector(right, aside).addScaledVector(up, above));
  }

  /** Keeps in the picture what moves out of it, unless a hand has taken the picture. */
  follow(box: Box3): void {
    if (this.isHandled || this.box.isEmpty() || this.box.containsBox(box)) return;
    this.box.union(box);
    this.aim();
  }

  private aim(from = this.camera.position.clone().sub(this.controls.target)): void {
    const { camera, controls } = this, target = this.box.getCenter(controls.target);
    from.normalize();
    camera.position.copy(target).add(from); // from which the distance is measured
    const distance = this.findDistance(from);
    camera.position.copy(target).addScaledVector(from, distance);
    controls.update();
  }

  /** Returns the distance at which the box fills the picture without being cut off. */
  private findDistance(from: Vector3): number {
    const { camera } = this, margin = 1.25, corner = new Vector3(), extent = this.box.getSize(new Vector3());
    camera.lookAt(this.controls.target);
    camera.updateMatrixWorld();
    const [right, up] = [new Vector3(), new Vector3()];
    camera.matrixWorld.extractBasis(right, up, new Vector3());
    const high = Math.tan((camera.fov * Math.PI) / 360), wide = high * camera.aspect;
    let distance = 0;
    for (let k = 0; k < 8; ++k) {
      corner.set(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5).multiply(extent);
      const needed = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / high);
      distance = Math.max(distance, corner.dot(from) + margin * needed);
    }
    return Math.max(distance, 0.1 * extent.length(), 100 * camera.near);
  }

  /** Returns the pixels of the page for a metre in the middle of the picture. */
  get pixelsPerMetre(): number {
    const away = this.camera.position.distanceTo(this.controls.target);
    return this.host.clientHeight / (2 * away * Math.tan((this.camera.fov * Math.PI) / 360));
  }
}

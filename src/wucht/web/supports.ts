/** Drawing of what holds the carrier: springs, dampers and mounts, the ground, a foundation, and what is fastened to it. */

import type { AttachmentData, MountData } from "./drawing_data.ts";
import type { Pose } from "./pose.ts";
import type { Pen } from "./shapes.ts";

/**
 * Of the larger side of the carrier: springs, the height of a foundation, buffers, and the places of dampers and stops beside
 * springs.
 */
export const SPRING = 0.3;
export const FOUNDATION = 0.11;
const BUFFER = 0.12;
const OFFSET = 0.055;
const BESIDE = 0.28;
/** Half the width of the ground under a mount. */
export const GROUND = 2.5 * OFFSET;

/** Where the mounts end, from the place on the carrier: on the ground, or on the foundation. */
export function drawMount(pen: Pen, pose: Pose, mount: MountData, unit: number, isPrescribed: boolean): void {
  const { ink, muted, surface } = pen.colours;
  const [a, b] = [pose.length(mount.x), pose.length(mount.y)];
  const [x1, y1] = [pose.placeX(a, b), pose.placeY(a, b)];
  const span = SPRING * unit;
  let x2 = a + mount.dx * span;
  let y2 = b + mount.dy * span;
  const side = OFFSET * unit * pen.scale;
  if (isPrescribed) {
    drawPrescribedMotion(pen, x1, y1, x2, y2, mount);
    return;
  }
  if (mount.is_on_foundation) {
    const [fx, fy] = [x2 + pose.foundationX, y2 + pose.foundationY];
    const depth = FOUNDATION * unit;
    drawPair(pen, x1, y1, fx, fy, mount, unit);
    const half = 0.3 * unit;
    pen.context.beginPath();
    for (const [s, t] of CORNERS) {
      const x = fx + mount.dx * depth * s + mount.dy * half * t;
      const y = fy + mount.dy * depth * s + mount.dx * half * t;
      pen.context.lineTo(pen.pixelX(x, y), pen.pixelY(x, y));
    }
    pen.context.closePath();
    pen.fill(surface);
    pen.stroke(ink, 1.3);
    const [middleX, middleY] = [fx + 0.5 * mount.dx * depth, fy + 0.5 * mount.dy * depth];
    pen.text("foundation", pen.pixelX(middleX, middleY), pen.pixelY(middleX, middleY), muted, 11, "center", null);
    const [gx, gy] = [x2 + mount.dx * (depth + span), y2 + mount.dy * (depth + span)];
    drawPair(pen, fx + mount.dx * depth, fy + mount.dy * depth, gx, gy, mount, unit);
    [x2, y2] = [gx, gy];
  } else {
    drawPair(pen, x1, y1, x2, y2, mount, unit);
  }
  pen.ground(x2, y2, mount.dx, mount.dy, 5 * side, ink);
}

const CORNERS = [[0, -1], [0, 1], [1, 1], [1, -1]] as const;

/** A spring, beside it a damper where there is damping. */
function drawPair(pen: Pen, x1: number, y1: number, x2: number, y2: number, mount: MountData, unit: number): void {
  const { ink } = pen.colours;
  const width = 0.62 * OFFSET * unit * pen.scale;
  const offset = mount.has_damper ? OFFSET * unit : 0;
  const [ox, oy] = [-mount.dy * offset, mount.dx * offset];
  pen.spring(x1 - ox, y1 - oy, x2 - ox, y2 - oy, width, ink);
  if (mount.has_damper) pen.dashpot(x1 + ox, y1 + oy, x2 + ox, y2 + oy, width, SPRING * unit * pen.scale, ink);
}

/** A rod that moves the carrier, with a double arrow. */
function drawPrescribedMotion(pen: Pen, x1: number, y1: number, x2: number, y2: number, mount: MountData): void {
  const { ink, muted } = pen.colours;
  const accent = pen.colours.accents[3];
  pen.line(x1, y1, x2, y2, ink, 2.2);
  pen.ground(x2, y2, mount.dx, mount.dy, 40, muted);
  const [cx, cy] = [pen.pixelX((x1 + x2) / 2, (y1 + y2) / 2), pen.pixelY((x1 + x2) / 2, (y1 + y2) / 2)];
  const heading = Math.atan2(-mount.dy, mount.dx);
  const [ux, uy] = [Math.cos(heading), Math.sin(heading)];
  const [nx, ny] = [-uy * 12, ux * 12];
  pen.context.beginPath();
  pen.context.moveTo(cx + nx - 14 * ux, cy + ny - 14 * uy);
  pen.context.lineTo(cx + nx + 14 * ux, cy + ny + 14 * uy);
  pen.stroke(accent, 1.6);
  pen.arrowHead(cx + nx + 14 * ux, cy + ny + 14 * uy, heading, accent);
  pen.arrowHead(cx + nx - 14 * ux, cy + ny - 14 * uy, heading + Math.PI, accent);
}

/** Ground below a carrier that does not move. */
export function drawFixture(pen: Pen, pose: Pose): void {
  const [left, bottom, right] = pose.machine.drawing.box;
  const middle = (pose.length(left) + pose.length(right)) / 2;
  const width = 0.6 * (pose.length(right) - pose.length(left)) * pen.scale;
  pen.ground(middle, pose.length(bottom), 0, -1, width, pen.colours.ink);
}

/** The bearing of a carrier that only turns. */
export function drawPivot(pen: Pen, pose: Pose, unit: number): void {
  const { ink, surface } = pen.colours;
  const [x, y] = [pose.pivotX, pose.pivotY];
  const bottom = Math.min(y, pose.length(pose.machine.drawing.box[1])) - 0.12 * unit;
  const half = Math.max(0.07 * unit, 0.4 * (y - bottom));
  pen.context.beginPath();
  pen.context.moveTo(pen.pixelX(x, y), pen.pixelY(x, y));
  pen.context.lineTo(pen.pixelX(x - half, bottom), pen.pixelY(x - half, bottom));
  pen.context.lineTo(pen.pixelX(x + half, bottom), pen.pixelY(x + half, bottom));
  pen.context.closePath();
  pen.fill(surface);
  pen.stroke(ink, 1.3);
  pen.ground(x, bottom, 0, -1, 2.6 * half * pen.scale, ink);
}

/** A part that is fastened to the carrier: a friction damper, a stop, or material on it. */
export function drawAttachment(pen: Pen, pose: Pose, attachment: AttachmentData, unit: number): void {
  if (attachment.kind === "material-layer") drawMaterial(pen, pose, attachment);
  else if (attachment.angle !== null) {
    const angle = pose.length(attachment.angle);
    if (attachment.gap === null) {
      const isUpward = Math.sin(angle) > 0.1;
      drawFrictionDamper(pen, pose, attachment, isUpward ? angle + Math.PI : angle, unit);
    } else {
      drawStop(pen, pose, attachment, angle, 1, unit);
      if (attachment.is_two_sided) drawStop(pen, pose, attachment, angle, -1, unit);
    }
  }
}

/** How far the border of the carrier is from a place on it in a direction. */
function borderDistance(pose: Pose, a: number, b: number, ux: number, uy: number): number {
  const [left, bottom, right, top] = pose.machine.drawing.box;
  const toX = ux === 0 ? Infinity : ((ux > 0 ? pose.length(right) : pose.length(left)) - a) / ux;
  const toY = uy === 0 ? Infinity : ((uy > 0 ? pose.length(top) : pose.length(bottom)) - b) / uy;
  return Math.max(0, Math.min(toX, toY));
}

function drawFrictionDamper(pen: Pen, pose: Pose, { x, y }: AttachmentData, angle: number, unit: number): void {
  const { ink, surface } = pen.colours;
  const [ux, uy] = [Math.cos(angle), Math.sin(angle)];
  const [a, b] = [pose.length(x), pose.length(y)];
  const out = borderDistance(pose, a, b, ux, uy);
  const [ra, rb] = [a + out * ux, b + out * uy];
  const span = SPRING * unit;
  const [gx, gy] = [ra + span * ux, rb + span * uy];
  const [cx, cy] = [pose.placeX(ra, rb), pose.placeY(ra, rb)];
  // The sleeve swings about its foot with the carrier, whose motion is magnified.
  const distance = Math.hypot(cx - gx, cy - gy) || span;
  const [vx, vy] = [(cx - gx) / distance, (cy - gy) / distance];
  const half = 0.05 * unit;
  pen.context.beginPath();
  for (const [s, t] of CORNERS) {
    const along = 0.6 * s * span;
    const [sx, sy] = [gx + along * vx - half * t * vy, gy + along * vy + half * t * vx];
    pen.context.lineTo(pen.pixelX(sx, sy), pen.pixelY(sx, sy));
  }
  pen.context.closePath();
  pen.fill(surface);
  pen.stroke(ink, 1.3);
  const rod = Math.min(0.68 * span, 0.95 * distance);
  const [ex, ey] = [cx - rod * vx, cy - rod * vy];
  pen.line(cx, cy, ex, ey, ink, 2);
  const piston = 0.85 * half;
  pen.line(ex - piston * vy, ey + piston * vx, ex + piston * vy, ey - piston * vx, pen.colours.accents[1], 4);
  pen.ground(gx, gy, ux, uy, 4 * half * pen.scale, ink);
}

/** A buffer on the ground beyond its gap, which is magnified as the motion is. */
function drawStop(pen: Pen, pose: Pose, part: AttachmentData, angle: number, side: number, unit: number): void {
  const { ink } = pen.colours;
  const accent = pen.colours.accents[3];
  const [ux, uy] = [side * Math.cos(angle), side * Math.sin(angle)];
  // Beside the springs of a carrier that only translates, where all places are alike.
  const beside = pose.machine.drawing.turning === "no" ? BESIDE * unit : 0;
  const [a, b] = [pose.length(part.x) + beside * Math.abs(uy), pose.length(part.y) + beside * Math.abs(ux)];
  const out = borderDistance(pose, a, b, ux, uy);
  const [ra, rb] = [a + out * ux, b + out * uy];
  let away = pose.length(part.gap!) + (part.rest === null ? 0 : side * pose.length(part.rest));
  for (const direction of pose.machine.drawing.carrier) {
    if (direction.label === "x") away -= pose.length(direction.rest) * ux;
    if (direction.label === "y") away -= pose.length(direction.rest) * uy;
  }
  const gap = away * pose.magnification;
  const depth = (pose.placeX(ra, rb) - ra) * ux + (pose.placeY(ra, rb) - rb) * uy;
  const head = Math.max(gap, depth);
  const end = gap + BUFFER * unit;
  const foot = Math.max(end, head + 0.25 * BUFFER * unit);
  const half = 0.06 * unit;
  const [hx, hy] = [ra + head * ux, rb + head * uy];
  pen.line(hx - half * uy, hy + half * ux, hx + half * uy, hy - half * ux, accent, 3);
  pen.spring(hx, hy, ra + foot * ux, rb + foot * uy, 0.03 * unit * pen.scale, ink);
  pen.ground(ra + foot * ux, rb + foot * uy, ux, uy, 3 * half * pen.scale, ink);
}

function drawMaterial(pen: Pen, pose: Pose, { x }: AttachmentData): void {
  const [left, , right, top] = pose.machine.drawing.box;
  const width = 0.7 * (pose.length(right) - pose.length(left));
  const [middle, height] = [pose.length(x), pose.length(top)];
  const radius = Math.max(2, 0.012 * width * pen.scale);
  const count = 28;
  for (let k = 0; k < count; k++) {
    const a = middle + width * (k / (count - 1) - 0.5);
    const b = height + (radius / pen.scale) * (1 + 1.6 * ((k * 7) % 3 === 0 ? 1 : 0));
    if (a > pose.length(left) && a < pose.length(right)) {
      pen.circle(pose.placeX(a, b), pose.placeY(a, b), radius, pen.colours.muted, null, 0);
    }
  }
}

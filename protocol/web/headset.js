// The picture in a headset: both eyes see the same panorama, and the head's pose is the view that the daemon is told.

export async function isThere() {
  return Boolean(await navigator.xr?.isSessionSupported('immersive-vr').catch(() => false));
}

// Enter a session, which draws picture until it ends. onFrame is called when a frame has been drawn;
// onView gets its View.
export async function enter(picture, onView, onFrame, onEnd) {
  const gl = picture.gl, session = await navigator.xr.requestSession('immersive-vr');
  await gl.makeXRCompatible();
  session.updateRenderState({ baseLayer: new XRWebGLLayer(session, gl) });
  const space = await session.requestReferenceSpace('local');
  const frame = (time, xr) => {
    session.requestAnimationFrame(frame);
    const pose = xr.getViewerPose(space), layer = session.renderState.baseLayer;
    if (!pose) return;
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    for (const view of pose.views) {
      const { x, y, width, height } = layer.getViewport(view);
      gl.viewport(x, y, width, height);
      picture.draw(toWorld(view));
    }
    onFrame();
    const { x, y, z, w } = pose.transform.orientation, p = pose.views[0].projectionMatrix;
    onView({ orientation: [x, y, z, w], fovX: 2 * Math.atan(1 / p[0]), fovY: 2 * Math.atan(1 / p[5]), headset: true });
  };
  session.addEventListener('end', () => {
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    onEnd();
  });
  session.requestAnimationFrame(frame);
  return session;
}

// From an eye's clip space to directions in the world. The eye's projection may be off-centre. Its position does not
// matter, because the panorama is far away.
function toWorld(view) {
  const p = view.projectionMatrix, m = view.transform.matrix;
  const column = (a, b, c) => [0, 1, 2].map((i) => m[i] * a + m[4 + i] * b + m[8 + i] * c);
  return [...column(1 / p[0], 0, 0), 0, ...column(0, 1 / p[5], 0), 0, ...column(p[8] / p[0], p[9] / p[5], -1), 0, 0, 0, 0, 1];
}

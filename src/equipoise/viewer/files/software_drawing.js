// A browser without a graphics card draws every pixel on the cores, four times over where edges are
// smoothed. There they are not: it is asked once what draws, and if that is a program, smoothing is off.
(() => {
  "use strict";
  const PROGRAMS = /swiftshader|llvmpipe|softpipe|software|basic render/i;
  const drawsInSoftware = () => {
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2") || canvas.getContext("webgl");
    if (!gl) return false;
    const told = gl.getExtension("WEBGL_debug_renderer_info");
    const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
    const lost = gl.getExtension("WEBGL_lose_context");
    if (lost) lost.loseContext();
    return PROGRAMS.test(name);
  };
  const wanted = HTMLCanvasElement.prototype.getContext;
  if (!drawsInSoftware()) return;
  HTMLCanvasElement.prototype.getContext = function (kind, settings, ...rest) {
    const plain = /^webgl/.test(kind) ? { ...settings, antialias: false } : settings;
    return wanted.call(this, kind, plain, ...rest);
  };
})();

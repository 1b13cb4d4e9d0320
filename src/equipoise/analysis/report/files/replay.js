// Plays the runs of a report in WebGL: rigid nodes of coloured triangles, one clock, one camera.
"use strict";
(() => {
  const all = JSON.parse(document.getElementById("replays").textContent);
  const bytes = key => Uint8Array.from(atob(all.blobs[key]), c => c.charCodeAt(0)).buffer;
  const camera = { yaw: -0.7, pitch: 0.3, distance: 2.6, target: [0.2, 0, 0.75] };
  const clock = { t: all.first, playing: false };

  const vertexShader = `
    attribute vec3 place, normal; uniform mat4 view; uniform vec4 turn; uniform vec3 shift;
    varying vec3 facing;
    vec3 turned(vec3 p) { return p + 2.0 * cross(turn.xyz, cross(turn.xyz, p) + turn.w * p); }
    void main() { facing = turned(normal); gl_Position = view * vec4(turned(place) + shift, 1.0); }`;
  const fragmentShader = `
    precision mediump float; uniform vec3 colour; uniform float lit; varying vec3 facing;
    void main() {
      float light = 0.45 + 0.4 * max(dot(normalize(facing), vec3(0.45, -0.55, 0.7)), 0.0)
        + 0.15 * normalize(facing).z;
      gl_FragColor = vec4(colour * mix(1.0, light, lit), 1.0); }`;

  function perspectiveView(aspect) {
    const [cy, sy] = [Math.cos(camera.yaw), Math.sin(camera.yaw)];
    const [cp, sp] = [Math.cos(camera.pitch), Math.sin(camera.pitch)];
    const back = [cy * cp, sy * cp, sp], right = [-sy, cy, 0];
    const up = [-cy * sp, -sy * sp, cp];
    const eye = camera.target.map((c, i) => c + camera.distance * back[i]);
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const f = 2.0, near = 0.05, far = 50, a = (far + near) / (near - far);
    const rows = [right.map(x => x * f / aspect), up.map(x => x * f), back.map(x => x * a), back.map(x => -x)];
    const b = 2 * far * near / (near - far);
    const columns = [0, 1, 2].flatMap(i => rows.map(row => row[i]));
    return new Float32Array([...columns, -dot(rows[0], eye), -dot(rows[1], eye),
      -dot(rows[2], eye) + b, -dot(rows[3], eye)]);
  }

  function program(gl) {
    const made = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source); gl.compileShader(shader); gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    return made;
  }

  function buffer(gl, kind, content) {
    const made = gl.createBuffer();
    gl.bindBuffer(kind, made); gl.bufferData(kind, content, gl.STATIC_DRAW);
    return made;
  }

  function floorLines() {
    const lines = [];
    for (let k = -20; k <= 20; k++) for (const [a, b] of [[k, 20], [k, -20]]) {
      if (b < 0) continue;
      lines.push(a * 0.1, -2, 0, a * 0.1, 2, 0, -2, a * 0.1, 0, 2, a * 0.1, 0);
    }
    return new Float32Array(lines);
  }

  class Replay {
    constructor(canvas, run) {
      this.canvas = canvas; this.run = run;
      const gl = this.gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
      if (!gl) { canvas.replaceWith("This browser shows no 3D pictures (WebGL)."); return; }
      this.program = program(gl);
      this.at = name => gl.getUniformLocation(this.program, name);
      this.place = gl.getAttribLocation(this.program, "place");
      this.normal = gl.getAttribLocation(this.program, "normal");
      gl.getExtension("OES_element_index_uint");
      this.poses = new Float32Array(bytes(run.poses));
      this.times = new Float32Array(bytes(run.times));
      this.lines = new Float32Array(bytes(run.lines));
      this.meshes = run.meshes.map(mesh => ({
        node: mesh.node, rgb: mesh.rgb,
        places: buffer(gl, gl.ARRAY_BUFFER, bytes(mesh.places)),
        normals: buffer(gl, gl.ARRAY_BUFFER, bytes(mesh.normals)),
        triangles: buffer(gl, gl.ELEMENT_ARRAY_BUFFER, bytes(mesh.triangles)), count: mesh.count }));
      this.floor = buffer(gl, gl.ARRAY_BUFFER, floorLines());
      this.forces = gl.createBuffer();
    }
    frame(t) {
      let low = 0, high = this.times.length - 1;
      while (low < high) { const mid = (low + high + 1) >> 1; this.times[mid] <= t ? low = mid : high = mid - 1; }
      return low;
    }
    draw(t) {
      const gl = this.gl;
      if (!gl) return;
      const width = this.canvas.clientWidth * Math.min(devicePixelRatio, 2) | 0;
      const height = this.canvas.clientHeight * Math.min(devicePixelRatio, 2) | 0;
      if (this.canvas.width !== width || this.canvas.height !== height) { this.canvas.width = width; this.canvas.height = height; }
      gl.viewport(0, 0, width, height); gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT); gl.enable(gl.DEPTH_TEST);
      gl.useProgram(this.program);
      gl.uniformMatrix4fv(this.at("view"), false, perspectiveView(width / height));
      const k = this.frame(t), nodes = this.run.nodes;
      gl.enableVertexAttribArray(this.place);
      gl.uniform1f(this.at("lit"), 1);
      gl.enableVertexAttribArray(this.normal);
      for (const mesh of this.meshes) {
        const pose = this.poses.subarray(7 * (k * nodes + mesh.node), 7 * (k * nodes + mesh.node) + 7);
        gl.uniform3fv(this.at("shift"), pose.subarray(0, 3)); gl.uniform4fv(this.at("turn"), pose.subarray(3, 7));
        gl.uniform3fv(this.at("colour"), mesh.rgb);
        gl.bindBuffer(gl.ARRAY_BUFFER, mesh.places); gl.vertexAttribPointer(this.place, 3, gl.FLOAT, false, 0, 0);
        gl.bindBuffer(gl.ARRAY_BUFFER, mesh.normals); gl.vertexAttribPointer(this.normal, 3, gl.BYTE, true, 4, 0);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.triangles);
        gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
      }
      gl.disableVertexAttribArray(this.normal); gl.vertexAttrib3f(this.normal, 0, 0, 1);
      gl.uniform1f(this.at("lit"), 0);
      gl.uniform3f(this.at("shift"), 0, 0, 0); gl.uniform4f(this.at("turn"), 0, 0, 0, 1);
      this.segments(this.floor, null, [0.8, 0.82, 0.85], 41 * 4);
      const size = this.run.segments * 6;
      this.segments(this.forces, this.lines.subarray(k * size, (k + 1) * size), [0.84, 0.16, 0.16], 2 * this.run.segments);
    }
    segments(made, content, rgb, count) {
      const gl = this.gl;
      gl.bindBuffer(gl.ARRAY_BUFFER, made);
      if (content) gl.bufferData(gl.ARRAY_BUFFER, content, gl.DYNAMIC_DRAW);
      gl.vertexAttribPointer(this.place, 3, gl.FLOAT, false, 0, 0);
      gl.uniform3fv(this.at("colour"), rgb); gl.drawArrays(gl.LINES, 0, count);
    }
  }

  const replays = all.runs.map((run, i) => run && new Replay(document.getElementById(`replay${i}`), run)).filter(Boolean);
  if (!replays.length) return;
  const [button, slider, shown] = ["play", "time", "shown"].map(id => document.getElementById(id));
  slider.min = all.first; slider.max = all.last; slider.step = "any";
  const draw = () => {
    for (const replay of replays) replay.draw(clock.t);
    slider.value = clock.t; shown.value = `${clock.t.toFixed(2)} s`; button.textContent = clock.playing ? "Pause" : "Play";
  };
  let before = 0;
  const tick = now => {
    if (!clock.playing) return;
    clock.t += Math.min((now - before) / 1000, 0.2); before = now;
    if (clock.t >= all.last) { clock.t = all.last; clock.playing = false; }
    draw();
    requestAnimationFrame(tick);
  };
  const toggle = () => {
    clock.playing = !clock.playing;
    if (clock.playing && clock.t >= all.last) clock.t = all.first;
    before = performance.now(); draw(); requestAnimationFrame(tick);
  };
  const seek = t => { clock.t = Math.min(Math.max(t, all.first), all.last); draw(); };
  button.onclick = toggle;
  slider.oninput = () => seek(Number(slider.value));
  document.addEventListener("keydown", event => {
    const jump = { ArrowLeft: -0.04, ArrowRight: 0.04 }[event.key];
    if (event.key === " " && event.target !== button) { event.preventDefault(); toggle(); }
    if (jump && event.target !== slider) { clock.playing = false; seek(clock.t + jump); }
  });
  for (const { canvas } of replays) {
    canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
    canvas.onpointermove = event => {
      if (!event.buttons) return;
      camera.yaw -= event.movementX * 0.008;
      camera.pitch = Math.min(Math.max(camera.pitch + event.movementY * 0.008, -0.2), 1.5); draw();
    };
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      camera.distance = Math.min(Math.max(camera.distance * Math.exp(event.deltaY * 0.001), 0.5), 12); draw();
    }, { passive: false });
  }
  addEventListener("resize", draw);
  draw();
})();

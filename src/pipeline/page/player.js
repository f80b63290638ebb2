// Movies, and what is pressed to play them.
'use strict';

/** Plays the runs' movies together, frame by frame; without any, a clock. */
class Player {
  constructor() {
    this.rate = (runs[0] && runs[0].playback_rate) || 30;
    this.tracks = [];
    this.playing = false;
    this.element = make('div', {class: 'movies'});
    runs.forEach((run, i) => this.element.append(this.figure(run, i)));
  }

  figure(run, i) {
    const movie = run.movie || {};
    const text = make('span', {}, movie.text || '');
    const name = several ? make('figcaption', {}, key(i), run.label, ' ', text) : make('figcaption', {}, text);
    if (!movie.data && !movie.href) return make('figure', {}, make('p', {class: 'note'}, movie.text || ''), several ? name : null);
    const source = movie.data ? URL.createObjectURL(new Blob([bytesOf(movie.data)], {type: 'video/mp4'}))
      : movie.href.split('/').map(encodeURIComponent).join('/');
    const video = make('video', {src: source, preload: 'auto', playsinline: '', 'aria-label': 'Movie of ' + run.label,
      onclick: () => this.toggle()});
    video.muted = true;
    const track = {video, rate: run.playback_rate || this.rate, last: lastOf(run)};
    this.tracks.push(track);
    this.tracks.sort((a, b) => b.last - a.last);
    video.addEventListener('error', () => {
      text.textContent = movie.href ? `This movie is not in the page, and not beside it at ${movie.href}.` : 'This browser cannot play the movie (H.264).';
      const playing = this.playing;
      this.pause();
      this.tracks = this.tracks.filter((other) => other !== track);
      if (playing) this.play();
    });
    video.addEventListener('ended', () => { if (track === this.leader) this.pause(); });
    // What the leader shows, the cursor says.
    const told = (time) => { if (this.playing && track === this.leader) this.reached(Math.round(time * track.rate)); };
    if (video.requestVideoFrameCallback) {
      const next = (now, meta) => { told(meta.mediaTime); video.requestVideoFrameCallback(next); };
      video.requestVideoFrameCallback(next);
    } else {
      video.addEventListener('timeupdate', () => told(Math.max(0, video.currentTime - 0.5 / track.rate)));
    }
    return make('figure', {}, video, several || movie.text ? name : make('figcaption', {}, text));
  }

  /** The movie that is longest: the others follow it. */
  get leader() { return this.tracks[0] || null; }

  /** The time in a movie that shows a frame: its middle, as on its edge a player may show the one before. */
  timeOf(track, frame) { return (Math.min(frame, track.last) + 0.5) / track.rate; }

  reached(frame) {
    cursor.set(frame, this);
    for (const track of this.tracks.slice(1)) {
      const late = Math.abs(track.video.currentTime - this.timeOf(track, frame));
      if (frame <= track.last && late > Math.max(0.12, 2 / track.rate)) track.video.currentTime = this.timeOf(track, frame);
    }
  }

  show(frame) {
    for (const track of this.tracks) track.video.currentTime = this.timeOf(track, frame);
    if (this.playing && !this.leader) this.tick();
  }

  toggle() { this.playing ? this.pause() : this.play(); }

  play() {
    if (cursor.frame >= cursor.last) cursor.set(0);
    this.playing = true;
    this.changed();
    if (!this.leader) return this.tick();
    for (const track of this.tracks) {
      track.video.playbackRate = this.leader.rate / track.rate;
      if (cursor.frame < track.last || track === this.leader) track.video.play().catch(() => this.pause());
    }
  }

  /** The clock of those without a movie. */
  tick() {
    const from = cursor.frame, begin = performance.now();
    const token = this.clock = {};
    const next = (now) => {
      if (!this.playing || this.clock !== token) return;
      const frame = from + Math.floor((now - begin) / 1000 * this.rate);
      cursor.set(frame, this);
      if (frame >= cursor.last) return this.pause();
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  }

  pause() {
    this.playing = false;
    for (const track of this.tracks) track.video.pause();
    this.show(cursor.frame);
    this.changed();
  }

  changed() {}
}

function controls(player) {
  const rate = runs[0].frame_rate || 60;
  const slider = make('input', {type: 'range', min: 0, max: cursor.last, value: 0, id: 'slider', 'aria-label': 'Frame',
    oninput: () => { player.pause(); cursor.set(Number(slider.value)); }});
  const text = make('output', {for: 'slider'});
  const button = make('button', {id: 'play', onclick: () => player.toggle()}, 'Play');
  player.changed = () => { button.textContent = player.playing ? 'Pause' : 'Play'; };
  const step = (by) => { player.pause(); cursor.set(cursor.frame + by); };
  const follower = cursor.follow({
    show(frame) {
      slider.value = frame;
      text.value = `frame ${frame} of ${cursor.last}, ${(frame / rate).toFixed(3)} s`;
    },
  });
  follower.show(0);
  document.addEventListener('keydown', (event) => {
    if (event.target.closest('input, select, button, summary, a, canvas') || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === ' ') { event.preventDefault(); player.toggle(); }
    if (event.key === 'ArrowLeft') step(-1);
    if (event.key === 'ArrowRight') step(1);
  });
  return make('div', {class: 'controls'}, button,
    make('button', {'aria-label': 'One frame back', onclick: () => step(-1)}, '‹'),
    make('button', {'aria-label': 'One frame on', onclick: () => step(1)}, '›'), slider, text);
}

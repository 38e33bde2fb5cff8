"use strict";
// Questions appear when the video was played to its end; answers are sent again until the server says that they are stored.
(() => {
  const { page, study, code, item } = document.body.dataset;
  const remembered = `visualspeech:${study}`;
  const find = (name) => document.getElementById(name);
  const keep = (storage, key, value) => { try { value === null ? storage.removeItem(key) : storage.setItem(key, value); } catch { /* storage is switched off */ } };
  const kept = (storage, key) => { try { return storage.getItem(key); } catch { return null; } };

  if (page === "consent") {
    const known = kept(localStorage, remembered);
    if (known && /^[0-9a-z]+$/.test(known)) {
      find("resume").querySelector("a").href = `/p/${known}`;
      find("resume").hidden = false;
    }
    return;
  }
  if (page === "sound" || page === "item") keep(localStorage, remembered, code);
  if (page === "done") keep(localStorage, remembered, null);
  // A page that the browser kept shows an earlier step.
  window.addEventListener("pageshow", (event) => { if (event.persisted) location.reload(); });
  if (page !== "item") return;

  const video = find("video"), play = find("play"), form = find("questions"), send = find("send"), message = find("message");
  const draft = `visualspeech:${code}:${item}`;
  const say = (text) => { message.textContent = text; message.hidden = !text; };
  const state = { played: false, values: {}, ...JSON.parse(kept(sessionStorage, draft) || "{}") };
  const save = () => keep(sessionStorage, draft, JSON.stringify(state));

  const covered = () => {
    let seconds = 0;
    for (let index = 0; index < video.played.length; index += 1) seconds += video.played.end(index) - video.played.start(index);
    return seconds;
  };
  const reveal = () => {
    form.hidden = false;
    find("hint").hidden = true;
  };
  // No controls lie over the video: they would cover the mouths.
  const label = () => { play.textContent = !video.paused && !video.ended ? "Pause" : video.ended || state.played ? "Play again" : "Play"; };
  const ended = () => {
    label();
    if (state.played) return;
    if (covered() < video.duration - 0.3) {
      say("A part of the video was skipped. Please play it from the beginning to the end.");
      return;
    }
    state.played = true;
    save();
    say("");
    reveal();
    form.querySelector("input").focus({ preventScroll: true });
    form.scrollIntoView({ block: "nearest", behavior: "smooth" });
  };
  const toggle = () => {
    if (video.error) video.load();
    if (!video.paused && !video.ended) { video.pause(); return; }
    if (video.ended) video.currentTime = 0;
    video.play().catch(() => say("The video could not be played. Please try again."));
  };
  play.addEventListener("click", toggle);
  play.disabled = false; // a press before this line would do nothing
  video.addEventListener("click", toggle);
  video.addEventListener("playing", () => { label(); if (!video.muted && video.volume > 0) say(""); });
  video.addEventListener("pause", label);
  video.addEventListener("ended", ended);
  video.addEventListener("timeupdate", () => { find("played").value = video.currentTime / (video.duration || 1); });
  video.addEventListener("ratechange", () => { if (video.playbackRate !== 1) video.playbackRate = 1; });
  const audible = () => {
    if ((video.muted || video.volume === 0) && !state.played) {
      video.pause();
      say("Please switch the sound on and play the video from the beginning.");
    }
  };
  video.addEventListener("volumechange", audible);
  video.addEventListener("play", audible);
  const broken = () => {
    label();
    say("The video could not be loaded. Please check the connection and press Play; if it stays away, tell the person who runs the study.");
  };
  video.addEventListener("error", broken);
  if (video.error) broken();

  const fieldsets = [...form.querySelectorAll("fieldset")];
  const values = () => Object.fromEntries(fieldsets.map((one) => {
    const chosen = one.querySelector("input:checked");
    return [one.dataset.question, chosen && (one.dataset.number ? Number(chosen.value) : chosen.value)];
  }));
  form.addEventListener("change", () => { state.values = values(); save(); });
  for (const one of fieldsets) {
    const value = state.values[one.dataset.question];
    for (const input of one.querySelectorAll("input")) input.checked = value !== undefined && value !== null && input.value === String(value);
  }
  if (state.played) reveal();
  label();

  const wait = (milliseconds) => new Promise((resolve) => {
    const timer = setTimeout(resolve, milliseconds);
    window.addEventListener("online", () => { clearTimeout(timer); resolve(); }, { once: true });
  });
  const post = async (body) => {
    for (let pause = 1000; ; pause = Math.min(pause * 2, 15000)) {
      try {
        const reply = await fetch(`/p/${code}/answers`, { method: "POST", headers: { "Content-Type": "application/json" }, body });
        if (reply.status < 500) return { status: reply.status, ...(await reply.json().catch(() => ({}))) };
        const told = await reply.json().catch(() => ({}));
        say(`${told.message || "The server could not store the answer."} Trying again ...`);
      } catch {
        say("The connection is lost. Your answer is kept on this page and sent as soon as the connection is back.");
      }
      await wait(pause);
    }
  };
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (send.disabled) return;
    send.disabled = true;
    const reply = await post(JSON.stringify({ item, played: state.played, answers: values() }));
    if (reply.stored || reply.status === 409) {
      keep(sessionStorage, draft, null);
      location.replace(`/p/${code}`);
      return;
    }
    send.disabled = false;
    say(reply.message || "The answer was not accepted.");
    if (reply.status === 422 && !state.played) form.hidden = true;
  });
})();

"""A video of the speaker who says one text."""

from visualspeech.animation.bundle import SpeakerBundle
from visualspeech.animation.performance import perform
from visualspeech.animation.speaking import speak
from visualspeech.animation.speaking_settings import SpeakSettings
from visualspeech.jobs import job
from visualspeech.speech.spoken import speak_text
from visualspeech.speech.spoken_settings import VoiceSettings

with job(snakemake.log[0]):
    bundle, voice = SpeakerBundle.load(snakemake.input[0]), VoiceSettings(**snakemake.params.voice)
    settings = SpeakSettings(label=snakemake.params.label)
    spoken = speak_text(snakemake.params.text, voice, bundle.shares, bundle.pronunciation)
    performance = perform(spoken, bundle.trained, bundle.rest)
    speak(snakemake.output[0], performance, bundle, f"synthetic (eSpeak NG, {voice.voice})", settings)

# The names of visualspeech.api.PUBLIC for type checkers and editors; a test compares both.
from visualspeech.api.exporting import export_run as export_run
from visualspeech.api.faces import NormalisedFace as NormalisedFace
from visualspeech.api.faces import SampledFaces as SampledFaces
from visualspeech.api.faces import TrackedFace as TrackedFace
from visualspeech.api.faces import fit_aam as fit_aam
from visualspeech.api.faces import fit_head as fit_head
from visualspeech.api.faces import normalise_pose as normalise_pose
from visualspeech.api.faces import sample_faces as sample_faces
from visualspeech.api.faces import track as track
from visualspeech.api.learning import predict as predict
from visualspeech.api.learning import train as train
from visualspeech.api.runs import Run as Run
from visualspeech.api.scores import score as score
from visualspeech.api.speaker import Said as Said
from visualspeech.api.speaker import Speaker as Speaker
from visualspeech.api.speech import align as align
from visualspeech.api.systems import System as System
from visualspeech.errors import DataError as DataError
from visualspeech.errors import RejectedUtterance as RejectedUtterance
from visualspeech.errors import SettingError as SettingError
from visualspeech.errors import StorageError as StorageError
from visualspeech.errors import VisualSpeechError as VisualSpeechError
from visualspeech.face.aam.model import Aam as Aam
from visualspeech.face.aam.model_settings import AamSettings as AamSettings
from visualspeech.face.aam.reference import texture_image as texture_image
from visualspeech.face.head import PoseSettings as PoseSettings
from visualspeech.face.screening import ScreeningSettings as ScreeningSettings
from visualspeech.face.tracker import LandmarkSettings as LandmarkSettings
from visualspeech.models.registry import load_model as load_model
from visualspeech.speech.alignment import Alignment as Alignment
from visualspeech.speech.alignment_settings import AlignmentSettings as AlignmentSettings
from visualspeech.speech.export import write_textgrid as write_textgrid
from visualspeech.speech.lexicon import Lexicon as Lexicon

__version__: str
__all__: list[str]

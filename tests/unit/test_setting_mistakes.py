"""Mistakes in settings: a sentence each that names the setting, the rule, and how to write what was meant."""

import math
import re

import pytest
import yaml

from tests.paths import REPOSITORY
from visualspeech.errors import SettingError
from visualspeech.planning.run import resolve
from visualspeech.schema import load_schema, mistakes
from visualspeech.settings import merged

CONFIG = REPOSITORY / "config"
SCHEMAS = REPOSITORY / "workflow" / "schemas"
LETTERS = "Hidden layers from the input up, one capital letter each, at most 16: F feed-forward, B bidirectional LSTM"
NETS = "systems.fan2015.models.nets"
FAN = "systems.fan2015"


def resolved(overlay):
    return resolve(merged(yaml.safe_load((CONFIG / "config.yaml").read_text()), yaml.safe_load(overlay)), CONFIG)


def system(changes):
    """An overlay that changes the system fan2015."""
    return f"override: {{systems: {{fan2015: {{{changes}}}}}}}"


def models(changes):
    """An overlay that changes the models of fan2015."""
    return system(f"models: {{{changes}}}")


def nets(changes):
    """An overlay that changes the networks of fan2015."""
    return models(f"nets: {{{changes}}}")


def coding(changes):
    """An overlay that changes the visual coding aam51."""
    return f"override: {{codings: {{aam51: {{{changes}}}}}}}"


def selected(changes):
    """An overlay that runs a second system, which extends fan2015."""
    return f"systems: [fan2015, {{name: mine, extends: fan2015, {changes}}}]"


@pytest.mark.parametrize(
    ("overlay", "said"),
    [
        # Settings of a family that may be lists, and their entries.
        (nets("letters: [FXB]"), f"`{NETS}.letters.0: FXB` must be of this form: {LETTERS}"),
        (nets("letters: [FB, fbb]"), f"`{NETS}.letters.1: fbb` must be of this form: {LETTERS}"),
        (nets("letters: ['']"), f"`{NETS}.letters.0: ''` must be of this form: {LETTERS}"),
        (nets("letters: [FBB-128]"), f"`{NETS}.letters.0: FBB-128` must be of this form: {LETTERS}"),
        (nets("letters: FXB"), f"`{NETS}.letters: FXB` must be of this form: {LETTERS}"),
        (nets("letters: []"), rf"`{NETS}.letters: \[\]` must have at least 1 entry. Hidden layers"),
        (nets("letters: [3]"), rf"`{NETS}.letters.0: 3` must be a text \(put it in quotes\)"),
        (nets("letters: [no]"), rf"`{NETS}.letters.0: false` must be a text \(YAML reads no, yes, on and off as"),
        (nets("letters: yes"), rf"`{NETS}.letters: true` must be a text \(YAML reads no, yes, on and off as"),
        (nets("letters: "), f"`{NETS}.letters` is empty and must be a text. Hidden layers"),
        (nets("letters: [FB, FB]"), rf"`{NETS}.letters: \[FB, FB\]` names FB more than once; give each once"),
        (nets("nodes: [0]"), f"`{NETS}.nodes.0: 0` must be at least 1 and at most 4096. Width of a hidden layer"),
        (nets("nodes: [-4]"), f"`{NETS}.nodes.0: -4` must be at least 1"),
        (nets("nodes: -4"), f"`{NETS}.nodes: -4` must be at least 1"),
        (nets("nodes: [16.5]"), rf"`{NETS}.nodes.0: 16.5` must be a whole number, at least 1 and at most 4096. "),
        (nets("nodes: [8, 16.0]"), f"`{NETS}.nodes.1: 16.0` must be a whole number, .*; write 16. "),
        (nets("nodes: ['16']"), f"`{NETS}.nodes.0: '16'` must be a whole number, .*; write 16. "),
        (nets("nodes: [yes]"), rf"`{NETS}.nodes.0: true` must be a whole number, at least 1 and at most 4096. "),
        (nets("nodes: [many]"), rf"`{NETS}.nodes.0: many` must be a whole number, at least 1 and at most 4096. "),
        (nets("nodes: [16, 16]"), rf"`{NETS}.nodes: \[16, 16\]` names 16 more than once"),
        (
            nets("nodes: [16, 15], b_nodes: layer"),
            f"`{NETS}.nodes.1: 15` must be even: with `b_nodes: layer` .* write 16",
        ),
        (nets("letters: FB, nodes: 15, b_nodes: layer"), f"`{NETS}.nodes: 15` must be even: with `b_nodes: layer`"),
        (nets("b_nodes: both"), f"`{NETS}.b_nodes: both` must be one of direction, layer. What the width of a B layer"),
        (nets("b_nodes: [layer]"), rf"`{NETS}.b_nodes: \[layer\]` must be one of direction, layer"),
        (
            nets("states: 5"),
            f"unknown setting `{NETS}.states`. Did you mean .* Known here: b_nodes, delta_step, fam",
        ),
        (nets("node: 5"), rf"unknown setting `{NETS}.node`. Did you mean `nodes`\? Known here: b_nodes, delta_step,"),
        (nets("seed: 5"), rf"unknown setting `{NETS}.seed`. Did you mean `seeds`\? Known here:"),
        (
            models("rich: {like: nets, letters: FB, nodes: [8, 15], b_nodes: layer}"),
            f"`{FAN}.models.rich.nodes.1: 15` must be even",
        ),
        (
            models("rich: {like: nets, letters: FB, nodes: 99999}"),
            f"`{FAN}.models.rich.nodes: 99999` must be at least 1 and at mo",
        ),
        # Keys that every entry may have.
        (nets("seeds: []"), rf"`{NETS}.seeds: \[\]` must have at least 1 entry"),
        (nets("seeds: [1, 2, 1]"), rf"`{NETS}.seeds: \[1, 2, 1\]` names 1 more than once"),
        (system("seeds: [1, 2, 1]"), rf"`{FAN}.seeds: \[1, 2, 1\]` names 1 more than once"),
        (system("seeds: [-1]"), f"`{FAN}.seeds.0: -1` must be at least 0"),
        (system("seeds: [12345678901]"), f"`{FAN}.seeds.0: 12345678901` must be at least 0 and at most 999999999"),
        (system("seeds: 3"), rf"`{FAN}.seeds: 3` must be a list; write \[3\]"),
        (nets("seeds: [a]"), f"`{NETS}.seeds.0: a` must be a whole number, at least 0"),
        (nets("reads: tri"), rf"`{NETS}.reads: tri` must be a list; write \[tri\]. Input blocks of the system"),
        (
            nets("reads: [tr]"),
            rf"`{NETS}.reads.0: tr` must be one of tri, tri_shares, .* Did you mean `tri`\? Input block",
        ),
        (
            nets("reads: [tri, 3]"),
            f"`{NETS}.reads.1: 3` must be one of tri, tri_shares, .* Input block of the system.",
        ),
        (nets("reads: [tri, tri]"), rf"`{NETS}.reads: \[tri, tri\]` names tri more than once"),
        (nets("reads: []"), rf"`{NETS}.reads: \[\]` must have at least 1 entry"),
        (
            models("x: {family: stack}"),
            "`systems.fan2015.models.x` lacks `reads`. Input blocks .* Known: tri, tri_shares, ",
        ),
        (
            models("hmm_monophone: {reads: [track, tri]}"),
            rf"`{FAN}.models.hmm_monophone.reads: \[track, tri\]` must have at most 1",
        ),
        (nets("training: 3"), f"`{NETS}.training: 3` must be lines of `key: value`. What differs from the system's"),
        (
            nets("training: {dropout: 1}"),
            f"`{NETS}.training.dropout: 1` must be at least 0 and below 1. Share of hidden",
        ),
        (nets("training: {seed: 1}"), f"unknown setting `{NETS}.training.seed`"),
        (
            nets("training: {learning_rat: 1}"),
            rf"unknown setting `{NETS}.training.learning_rat`. Did you mean `learning_rate`\? Known h",
        ),
        (
            models("hmm_mge: {training: {}}"),
            f"`{FAN}.models.hmm_mge.training` is for networks; the family hmm .* Leave it out.",
        ),
        (
            models("hmm_mge: {seeds: [1]}"),
            f"`{FAN}.models.hmm_mge.seeds` is for networks; the family hmm is trained in another way",
        ),
        (nets("title: ''"), f"`{NETS}.title: ''` must not be empty"),
        (nets("suffix: a/b"), f"`{NETS}.suffix: a/b` must be of this form: At most 32 letters, digits, - and _"),
        (nets("suffix: 2"), rf"`{NETS}.suffix: 2` must be a text \(put it in quotes\)"),
        # Families, and entries that others are made from.
        (
            models("x: {family: stak, reads: [tri]}"),
            rf"`{FAN}.models.x.family: stak` must be one of stack, hmm.* mean `stack`\?",
        ),
        (models("x: {family: [stack]}"), rf"`{FAN}.models.x.family: \[stack\]` must be one of stack, hmm, ensemble"),
        (
            models("x: {reads: [tri]}"),
            f"`{FAN}.models.x` lacks `family`. Family of models, .* Known: stack, hmm, ensemble, gv",
        ),
        (
            models("hmm_tied: {from: hmm_monophon}"),
            rf"`{FAN}.models.hmm_tied.from: hmm_monophon` is no entry of `models`. Did you",
        ),
        (
            models("x: {like: net}"),
            rf"`{FAN}.models.x.like: net` is no entry of `models`. Did you mean `nets`\? Known: nets, articulate, ",
        ),
        (models("x: {like: 3}"), rf"`{FAN}.models.x.like: 3` must be a text \(put it in quotes\)"),
        (models("x: {like: x}"), f"`{FAN}.models.x.like: x` leads back to x; name another entry."),
        (
            models("hmm_monophone: {from: hmm_mge}"),
            f"`{FAN}.models.hmm_monophone.from: hmm_mge` leads back to hmm_monophone; name ano",
        ),
        (
            models("hmm_tied: {like: nets}"),
            f"`{FAN}.models.hmm_tied` has both `like` and `from`; `from` takes over settings too",
        ),
        (
            models("hmm_tied: {from: nets}"),
            f"`{FAN}.models.hmm_tied.from: nets` asks for a model for each of its letters and nodes, and",
        ),
        (
            models("hmm_tied: {family: stack}"),
            f"`{FAN}.models.hmm_tied.family: stack` must be hmm, the family of the entry that `from`",
        ),
        (
            models("x: {family: hmm, variant: mge, reads: [track]}"),
            f"`{FAN}.models.x` lacks `from`: with these settings a model",
        ),
        (models("hmm_monophone: "), f"`{FAN}.models.hmm_tied.from: hmm_monophone` is no entry of `models`"),
        (models("x: {like: nets}"), f"`{FAN}.models.x`: two rows are named FFF-64 .*; give one a `suffix`"),
        (
            models("fbb-128: {family: mean}"),
            f"`{FAN}.models.fbb-128`: two rows are named fbb-128 .capitals do not count",
        ),
        (
            models("x: 3"),
            f"`{FAN}.models.x: 3` must be lines of `key: value`. One entry; a list for letters or nodes gives a row",
        ),
        (
            models("a/b: {family: mean}"),
            "`systems.fan2015.models`: a/b is no possible name. At most 64 letters, digits",
        ),
        (
            models("no: {family: mean}"),
            rf"`{FAN}.models`: false is no possible name \(YAML reads no, yes, on and off as",
        ),
        (
            system("models: [nets]"),
            r"`systems.fan2015.models: \[nets\]` must be lines of `key: value`. Rows of the tab",
        ),
        # Single settings of families.
        (
            models("hmm_tied: {variant: triphone}"),
            f"`{FAN}.models.hmm_tied.variant: triphone` must be one of monophone, tied, mge. Stage",
        ),
        (
            models("hmm_tied: {variant: [tied, mge]}"),
            rf"`{FAN}.models.hmm_tied.variant: \[tied, mge\]` must be one of monophone, tied",
        ),
        (
            models("hmm_monophone: {states: 0}"),
            f"`{FAN}.models.hmm_monophone.states: 0` must be at least 1 and at most 20. Number of states per phone",
        ),
        (
            models("hmm_monophone: {tree_per_phone: 1}"),
            rf"`{FAN}.models.hmm_monophone.tree_per_phone: 1` must be true or false\. ",
        ),
        (
            models("triphone_state_mean: {context: quinphone}"),
            f"`{FAN}.models.triphone_state_mean.context: quinphone` must be one of phone, triphone. Did",
        ),
        # Input blocks.
        (
            system("blocks: {parts: {parts: [tone]}}"),
            f"`{FAN}.blocks.parts.parts.0: tone` must be one of position_in_sy",
        ),
        (system("blocks: {parts: {parts: []}}"), rf"`{FAN}.blocks.parts.parts: \[\]` must have at least 1 entry"),
        (
            system("blocks: {parts: {parts: stress}}"),
            rf"`{FAN}.blocks.parts.parts: stress` must be a list; write \[str",
        ),
        (
            system("blocks: {parts: {parts: [stress, stress]}}"),
            rf"`{FAN}.blocks.parts.parts: .* names stress more than",
        ),
        (
            system("blocks: {ctx: {kind: linguistic, features: [position, tone]}}"),
            f"`{FAN}.blocks.ctx.features.1: tone` must be one of position, number_of_frames, forward_span, acoustic_cl",
        ),
        (
            system("blocks: {ctx: {kind: linguistic, features: [word, position, word]}}"),
            rf"`{FAN}.blocks.ctx.features: .* names word more than once",
        ),
        (
            system("blocks: {ph: {kind: phone, long_pause: -1}}"),
            f"`{FAN}.blocks.ph.long_pause: -1` must be at least 0",
        ),
        (
            system("blocks: {tri: {kind: triphone}}"),
            rf"`{FAN}.blocks.tri.kind: triphone` must be one of dynamic_visemes, full_context, label_parts",
        ),
        (
            system("blocks: {tri: {size: 1}}"),
            f"unknown setting `{FAN}.blocks.tri.size`. Known here: fractional, kind, states.",
        ),
        (system("blocks: {x: {}}"), f"`{FAN}.blocks.x` lacks `kind`. Kind of input block."),
        (system("blocks: {x: 3}"), f"`{FAN}.blocks.x: 3` must be lines of `key: value`. Kind and settings of a block"),
        (
            system("blocks: {Big: {kind: phone_track}}"),
            f"`{FAN}.blocks`: Big is no possible name. At most 32 small letters",
        ),
        (system("blocks: 3"), f"`{FAN}.blocks: 3` must be lines of `key: value`"),
        # Models that are named elsewhere.
        (
            system("videos: {model: BBB-512}"),
            rf"`{FAN}.videos.model: BBB-512` is no model of the system. Did you mean `BBB",
        ),
        (
            system("videos: {model: reconstruction}"),
            f"`{FAN}.videos.model: reconstruction` is no model of the system. Kno",
        ),
        (system("videos: {label: 1}"), rf"`{FAN}.videos.label: 1` must be true or false\. "),
        (
            system("trajectories: {models: [FBB-128, x]}"),
            f"`{FAN}.trajectories.models.1: x` is no model of the system. Known:",
        ),
        (
            system("trajectories: {models: [FBB-128, FBB-128]}"),
            f"`{FAN}.trajectories.models: .* names FBB-128 more than once",
        ),
        (
            system("trajectories: {models: [a, b, c, d, e, f, g, h]}"),
            f"`{FAN}.trajectories.models: .* must have at most 7 entries",
        ),
        (
            system("tables: {topologies: [net]}"),
            f"`{FAN}.tables.topologies.0: net` is no entry of `models` and no row. Did",
        ),
        (
            system("tables: {gains: {candidates: [net]}}"),
            f"`{FAN}.tables.gains.candidates.0: net` is no entry of `models`",
        ),
        (
            system("tables: {gains: {references: [hmm]}}"),
            f"`{FAN}.tables.gains.references.0: hmm` is no entry of `models`",
        ),
        (system("tables: {topologies: nets}"), rf"`{FAN}.tables.topologies: nets` must be a list; write \[nets\]"),
        (system("tables: {comparison: {level: 5}}"), f"`{FAN}.tables.comparison.level: 5` must be above 0 and below 1"),
        (
            system("tables: {comparison: {level: high}}"),
            f"`{FAN}.tables.comparison.level: high` must be a number, above 0",
        ),
        (
            system("tables: {comparison: {test: t}}"),
            f"`{FAN}.tables.comparison.test: t` must be one of wilcoxon, permut",
        ),
        (system("tables: {metrics: [rmse]}"), f"`{FAN}.tables.metrics.0: rmse` is no measure.* Known: rmse_shape"),
        (system("tables: {metrics: []}"), rf"`{FAN}.tables.metrics: \[\]` must have at least 1 entry"),
        (
            "speak: {model: FBB-127}",
            r"`speak.model: FBB-127` is no model of fan2015. Did you mean `FBB-128`\? Known: FFF-64",
        ),
        (
            "speak: {system: fan2016}",
            r"`speak.system: fan2016` is no selected system. Did you mean `fan2015`\? Known: fan",
        ),
        # Visual codings.
        (
            coding("source: fitted"),
            r"`codings.aam51.source: fitted` must be one of landmarks, fit. Did you mean `fit`\? Wher",
        ),
        (
            coding("source: no"),
            r"`codings.aam51.source: false` must be one of landmarks, fit \(YAML reads no, yes, on and",
        ),
        (
            coding("points: lower_face"),
            r"`codings.aam51.points: lower_face` is no point set. Did you mean `lower_face_51`\?",
        ),
        (coding("aam: {shape: {components: 0}}"), "`codings.aam51.aam.shape.components: 0` must be at least 1"),
        (
            coding("aam: {shape: {energy: 0.9, components: 3}}"),
            "`codings.aam51.aam.shape: .* must have either `energy` or `components`. Components of the shape",
        ),
        (
            coding("aam: {shape: {components: 3, at_most: 5}}"),
            "`codings.aam51.aam.shape: .* has `at_most`, which goes with `energy` alone. Components of the shape",
        ),
        (
            coding("aam: {shape: {components: 93}}"),
            "`codings.aam51.aam.shape.components: 93` is more than there can be: 92 tracked coordinates give 92",
        ),
        (
            coding("aam: {images: 10, texture: {components: 10}}"),
            "`codings.aam51.aam.texture.components: 10` is more than there can be: 10 images give 9 at most. Ask",
        ),
        (
            coding("aam: {shape: {components: 9}, texture: {components: 9}, appearance: {components: 19}}"),
            "`codings.aam51.aam.appearance.components: 19` is more than there can be: 9 shape and 9 texture components",
        ),
        (coding("aam: {shape: {energy: 1.5}}"), "`codings.aam51.aam.shape.energy: 1.5` must be above 0 and below 1"),
        (coding("aam: {shap: {energy: 0.9}}"), r"unknown setting `codings.aam51.aam.shap`\. Did you mean `shape`\?"),
        (coding("aam: {seed: 3}"), "unknown setting `codings.aam51.aam.seed`"),
        (coding("aam: {images: 300.0}"), "`codings.aam51.aam.images: 300.0` must be a whole number, .*; write 300"),
        (
            coding("texture: {texture_pixels: 40000}"),
            "`codings.aam51.texture.texture_pixels: 40000` must be at least 100 and at most 30000. Approximate number",
        ),
        (coding("aam: "), "`codings.aam51.aam` is empty and must be lines of `key: value`"),
        (
            coding("extends: x"),
            "`override.codings.aam51.extends` cannot be changed for one run; write it in the file of a",
        ),
        (
            selected("coding: 3"),
            "`systems.mine.coding: 3` is not known. Known: aam34, aam51, markers. Or give the path of a YAML file.",
        ),
        (
            selected("coding: aam15"),
            r"`systems.mine.coding: aam15` is not known. Did you mean `aam51`\? Known: aam34, aam51, markers. Or",
        ),
        (
            selected("coding: {points: x}"),
            "`systems.mine.coding` lacks `name`. Folder of the results: at most 64 letters",
        ),
        (
            selected("coding: {name: aam51, kind: aam, points: lower_face_51}"),
            "`systems.mine.coding`: another system defines",
        ),
        (
            selected("coding: {name: small, extends: aam15}"),
            r"`codings.small.extends: aam15` is not known. Did you mean",
        ),
        (
            selected("coding: {name: small, extends: aam51, size: 3}"),
            "unknown setting `codings.small.size`. Known here: aam,",
        ),
        # The whole of a system.
        (
            system("training: {learning_rate: 0}"),
            f"`{FAN}.training.learning_rate: 0` must be above 0 and at most 1. Step s",
        ),
        (
            system("training: {learning_rate: 1e-3}"),
            f"`{FAN}.training.learning_rate: 1e-3` must be a number, .*; write 0.001",
        ),
        (
            system("training: {learning_rate: 1e-6}"),
            f"`{FAN}.training.learning_rate: 1e-6` must be a number, .*; write 0.000001",
        ),
        (
            system("training: {learning_rate: .nan}"),
            f"`{FAN}.training.learning_rate: .nan` must be a number, above 0 and at",
        ),
        (
            system("training: {max_grad_norm: .inf}"),
            f"`{FAN}.training.max_grad_norm: .inf` must be a number, at least 0",
        ),
        (system("training: {dropout: 1}"), f"`{FAN}.training.dropout: 1` must be at least 0 and below 1"),
        (system("training: {ema_decay: 1.5}"), f"`{FAN}.training.ema_decay: 1.5` must be at least 0 and below 1"),
        (system("training: {max_epochs: 0}"), f"`{FAN}.training.max_epochs: 0` must be at least 1"),
        (system("training: {optimiser: sgd}"), f"`{FAN}.training.optimiser: sgd` must be one of adam, paper"),
        (
            system("training: {scaling: no}"),
            rf"`{FAN}.training.scaling: false` must be one of global, .* \(YAML reads no, y",
        ),
        (system("training: [1]"), rf"`{FAN}.training: \[1\]` must be lines of `key: value`"),
        (system("training: {seed: 1}"), f"unknown setting `{FAN}.training.seed`"),
        (
            system("needs: [vidio]"),
            rf"`{FAN}.needs.0: vidio` must be one of video, audio, .* Did you mean `video`\? One kin",
        ),
        (system("needs: [text, text]"), f"`{FAN}.needs: .* names text more than once"),
        (system("rate: -25"), f"`{FAN}.rate: -25` must be at least 0 and at most 1000. Frames per second"),
        (
            system("published: fan2016"),
            rf"`{FAN}.published: fan2016` is not known. Did you mean `fan2015`\? Known: fan2015",
        ),
        (system("published: no"), rf"`{FAN}.published: false` must be a text \(YAML reads no, yes, on and off as"),
        (
            system("tilte: x"),
            rf"unknown setting `{FAN}.tilte`. Did you mean `title`\? Known here: blocks, coding, models",
        ),
        (
            system("name: x"),
            "`override.systems.fan2015.name` cannot be changed for one run; write it in the file of a syst",
        ),
        (
            "override: {systems: {fan2015: 3}}",
            "`override.systems.fan2015: 3` must be lines of `key: value`. The keys of",
        ),
        ("override: {systems: {fan2015: }}", "`override.systems.fan2015` is empty and must be lines of `key: value`"),
        (
            "override: {systems: {fan2016: {}}}",
            r"`override.systems: fan2016` is not known. Did you mean `fan2015`\? Known",
        ),
        (
            "override: {codings: {aam15: {}}}",
            r"`override.codings: aam15` is not known. Did you mean `aam51`\? Known: aam34, aam51",
        ),
        (
            "override: {system: {}}",
            r"unknown setting `override.system`. Did you mean `systems`\? Known here: codings, studies, sys",
        ),
        (
            "override: 3",
            "`override: 3` must be lines of `key: value`. Changes of single systems, codings and studies, by name.",
        ),
        (
            "systems: 3",
            r"`systems: 3` must be a list, a text or lines of `key: value` \(put it in quotes\). The published",
        ),
        (
            "systems: [no]",
            r"`systems.0: false` must be a text or lines of `key: value` \(YAML reads no, yes, on and off",
        ),
        ("systems: []", r"`systems: \[\]` must have at least 1 entry. The published systems"),
        ("systems: ", "`systems` is empty and must be a list, a text or lines of `key: value`"),
        (
            "systems: fan2016",
            r"`systems: fan2016` is not known. Did you mean `fan2015`\? Known: fan2015, fan2015_50hz, ",
        ),
        ("systems: [fan2015, fan2016]", r"`systems.1: fan2016` is not known. Did you mean `fan2015`\?"),
        (
            "systems: [fan2015, fan2015]",
            "`systems.1: fan2015`: `systems` names fan2015 more than once .*; give each its",
        ),
        ("systems: [fan2015, {name: FAN2015, extends: fan2015}]", "`systems.1: FAN2015`: `systems` names FAN2015 more"),
        ("systems: {extends: fan2015}", "`systems` lacks `name`. Folder of the results: at most 64 letters, digits"),
        (
            "systems: {name: 5, extends: fan2015}",
            r"`systems.name: 5` must be a text \(put it in quotes\). Folder of the",
        ),
        ("systems: {name: a/b, extends: fan2015}", "`systems.name: a/b` must be of this form: Folder of the results"),
        (
            "systems: {name: tables, extends: fan2015}",
            "`systems.tables`: tables is the name of a folder of the results",
        ),
        (
            "systems: {name: x, extends: fan2016}",
            r"`systems.x.extends: fan2016` is not known. Did you mean `fan2015`\?",
        ),
        (
            "systems: {name: x, extends: fan2015, rate: fast}",
            "`systems.x.rate: fast` must be a number, at least 0 and at",
        ),
        ("systems: nowhere.yaml", "cannot read nowhere.yaml: No such file or directory."),
        # The run.
        (
            "pose: {focal_length: wide}",
            "`pose.focal_length: wide` must be a number, at least 0.1 and at most 1000. Assume",
        ),
        ("speak: {sentences: []}", r"`speak.sentences: \[\]` must have at least 1 entry. What the target speak says"),
        ("speak: {sentences: ['']}", "`speak.sentences.0: ''` must not be empty"),
        ("speak: {sentences: [no]}", "`speak.sentences.0: false` must be a text .*put a text in quotes"),
        ("speak: {sentences: [12]}", r"`speak.sentences.0: 12` must be a text \(put it in quotes\)"),
        ("speak: {voice: {pitch: 200}}", "`speak.voice.pitch: 200` must be at least 0 and at most 100. Pitch"),
        ("shards: four", "`shards: four` must be a whole number, at least 1 and at most 1000. Parts in which"),
        ("shards: 16.0", "`shards: 16.0` must be a whole number, .*; write 16"),
        ("shards: 16.5", "`shards: 16.5` must be a whole number, at least 1 and at most 1000. Parts"),
        ("shards: '16'", "`shards: '16'` must be a whole number, .*; write 16"),
        ("shards: yes", "`shards: true` must be a whole number, at least 1 and at most 1000. "),
        ("shards: -4", "`shards: -4` must be at least 1"),
        ("shards: ", "`shards` is empty and must be a whole number"),
        (
            system("title: no"),
            rf"`{FAN}.title: false` must be a text \(YAML reads no, yes, on and off as false and true",
        ),
        (system("title: 3"), rf"`{FAN}.title: 3` must be a text \(put it in quotes\)"),
        (
            models("x: {family: mean, reads: [tri]}"),
            f"`{FAN}.models.x.reads` must be left out: the family mean reads no",
        ),
        ("seed: 12345678901", "`seed: 12345678901` must be at least 0 and at most 999999999"),
        ("sed: 3", r"unknown setting `sed`\. Did you mean `seed`\? Known here: alignment, check"),
        (
            "no: 3",
            r"unknown setting `false` \(YAML reads no, yes, on and off as false and true; .* Known here: alignment",
        ),
        (
            "training: {dropout: 0}",
            "`training` is a setting of systems, `override.systems.fan2015.training`. Write `override: {systems",
        ),
        ("split: {train: 0.9}", "`split`: the shares must sum to 1, they sum to 1.1."),
        ("split: {train: 1}", "`split.train: 1` must be above 0 and below 1. Share that models learn from."),
        ("results: ''", "`results: ''` must not be empty. Folder of all results"),
        # Corpora.
        (
            "corpora: demmo",
            r"`corpora: demmo` is not known. Did you mean `demo`\? Known: demo, demo_pair, grid, iemocap. Or give",
        ),
        ("corpora: [demmo]", r"`corpora.0: demmo` is not known. Did you mean `demo`\?"),
        ("corpora: []", r"`corpora: \[\]` must have at least 1 entry. The recordings: each a name"),
        (
            "corpora: [3]",
            r"`corpora.0: 3` must be a text or lines of `key: value` \(put it in quotes\). Name, path or map",
        ),
        ("corpora: [demo, demo]", "`corpora.1: demo`: `corpora` names demo more than once"),
        ("corpora: {name: mine}", "`corpora.mine` lacks `adapter`. How the recordings lie on disk."),
        ("corpora: {adapter: folder}", "`corpora` lacks `name`. Folder of the results"),
        (
            "corpora: {name: a b, adapter: folder}",
            "`corpora.name: a b` must be of this form: Folder of the results: at",
        ),
        (
            "corpora: {name: x, adapter: foldr}",
            r"`corpora.x.adapter: foldr` must be one of demo, folder, grid, iemocap, mocap. Did you m",
        ),
        ("corpora: [{name: x, adapter: folder, root: 5}]", r"`corpora.x.root: 5` must be a text \(put it in quotes\)"),
        (
            "corpora: {name: x, adapter: folder, rot: 5}",
            r"unknown setting `corpora.x.rot`. Did you mean `root`\? Known he",
        ),
        (
            "corpora: {name: x, adapter: demo, utterances: 2}",
            "`corpora.x.utterances: 2` must be at least 3 and at most",
        ),
        ("corpora: {name: x, adapter: demo, limit: -1}", "`corpora.x.limit: -1` must be at least 0 and at most"),
    ],
)
def test_every_mistake_is_a_sentence(overlay, said):
    with pytest.raises(SettingError, match=f"^{said}") as told:
        resolved(overlay)
    assert len(str(told.value).splitlines()) == 1


def test_all_mistakes_are_told_at_once():
    with pytest.raises(SettingError) as told:
        resolved(
            "{shards: 0, corpora: {name: x, adapter: no}, override: {codings: {aam51: {aam: {images: 0}}},"
            " systems: {fan2015: {training: {dropout: 1, colour: 1, clip: 1}, blocks: {x: {kind: y}},"
            " models: {hmm_monophone: {family: hm}, nets: {nodes: [0, two]}}}}}}"
        )
    lines = str(told.value).splitlines()
    assert [re.search("`(.*?)`", line)[1] for line in lines] == [
        "shards: 0", "corpora.x.adapter: false", "codings.aam51.aam.images: 0", f"{FAN}.training.colour",
        f"{FAN}.training.clip", f"{FAN}.training.dropout: 1", f"{FAN}.blocks.x.kind: y",
        f"{FAN}.models.hmm_monophone.family: hm", f"{NETS}.nodes.0: 0", f"{NETS}.nodes.1: two",
    ]  # fmt: skip


def test_what_does_not_go_together_is_told_at_once_too():
    with pytest.raises(SettingError) as told:
        resolved(
            "{split: {train: 0.7}, override: {codings: {aam51: {points: x}},"
            " systems: {fan2015: {videos: {model: x}, trajectories: {models: [x, y]}, tables: {topologies: [x]}}}}}"
        )
    lines = str(told.value).splitlines()
    assert [line.split("`")[1] for line in lines] == [
        "split", "codings.aam51.points: x", f"{FAN}.tables.topologies.0: x", f"{FAN}.videos.model: x",
        f"{FAN}.trajectories.models.0: x", f"{FAN}.trajectories.models.1: y",
    ]  # fmt: skip


def test_every_network_that_cannot_be_is_told():
    with pytest.raises(SettingError) as told:
        resolved(nets("letters: [FB, FF], nodes: [15, 17], b_nodes: layer"))
    lines = str(told.value).splitlines()
    assert [line.split("`")[1] for line in lines] == [f"{NETS}.nodes.0: 15", f"{NETS}.nodes.1: 17"]


def test_a_mistake_is_told_where_it_is_written_not_where_it_is_inherited():
    with pytest.raises(SettingError) as told:
        resolved(models("nets: {nodes: [0]}, rich: {like: nets, suffix: rich}, hmm_monophone: {states: 0}"))
    lines = str(told.value).splitlines()
    assert [line.split("`")[1] for line in lines] == [
        f"{NETS}.nodes.0: 0",
        f"{FAN}.models.hmm_monophone.states: 0",
    ]


def test_missing_keys_are_named_one_by_one():
    with pytest.raises(SettingError) as told:
        resolved("systems: {name: x, title: Mine}")
    assert [line.split(".")[1] for line in str(told.value).splitlines()] == [
        f"x` lacks `{key}`" for key in ("rate", "needs", "coding", "blocks", "models")
    ]
    assert mistakes({}, load_schema(SCHEMAS / "run.schema.yaml"))[0].startswith("the configuration lacks `corpora`. Th")


def test_a_system_that_extends_itself(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, above in (("a", "b"), ("b", "c"), ("c", "a")):
        (tmp_path / f"{name}.yaml").write_text(f"extends: {above}.yaml\n")
    with pytest.raises(SettingError, match=r"`systems.c.extends: a.yaml` leads back to a \(a -> b -> c -> a\); extend"):
        resolved("systems: a.yaml")
    (tmp_path / "one.yaml").write_text("extends: one.yaml\n")
    with pytest.raises(SettingError, match=r"`codings.one.extends: one.yaml` leads back to one"):
        resolved(selected("coding: one.yaml"))
    (tmp_path / "two.yaml").write_text("name: 2\nextends: fan2015\n")
    with pytest.raises(SettingError, match=r"`two.yaml.name: 2` must be a text \(put it in quotes\)"):
        resolved("systems: [two.yaml]")


def test_what_is_written_as_told_is_taken():
    rows = resolved(system("training: {learning_rate: 0.000001, max_grad_norm: 0, ema_decay: 0}"))["systems"]["fan2015"]
    training = rows["rows"][0]["training"]
    assert training["learning_rate"] == 1e-6 and training["max_grad_norm"] == 0
    assert not any(isinstance(value, float) and math.isnan(value) for value in training.values())
    overlay = system("videos: {model: ''}, models: {nets: {letters: FB, nodes: [16]}, hmm_mge: }")
    rows = resolved(overlay)["systems"]["fan2015"]["rows"]
    assert [row["name"] for row in rows][:3] == ["FB-16", "FBB-128-lips", "FBB-128-mel"]


def test_a_corpus_file_with_a_root_that_is_no_text(tmp_path):
    (tmp_path / "mine.yaml").write_text("name: mine\nadapter: folder\nroot: 5\n")
    with pytest.raises(SettingError, match="`corpora.mine.root: 5` must be a text"):
        resolved(f"corpora: {tmp_path / 'mine.yaml'}")

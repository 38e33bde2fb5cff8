"""A folder of recordings as people have them."""

import pytest

from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.folder import utterances
from visualspeech.errors import CorpusError, SettingError


def corpus(root, **settings):
    return {"name": "mine", "adapter": "folder", "root": str(root), **settings}


def test_a_text_file_beside_each_video(tmp_path):
    (tmp_path / "anna").mkdir()
    for name in ("one.MP4", "anna/two words.mov", "._one.mp4", "three.mpg"):
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "one.txt").write_text("First line,\n second   line.\n")
    (tmp_path / "anna" / "two words.txt").write_text("Zwei")
    found = {one.id: one for one in utterances(corpus(tmp_path))}
    assert sorted(found) == ["anna-two_words-15f3deafd9", "one", "three"]
    assert found["one"].transcript == "First line, second line."
    assert found["three"].transcript == ""
    assert (found["one"].speaker, found["anna-two_words-15f3deafd9"].speaker) == ("mine", "anna")
    assert found["one"].media == str(tmp_path / "one.MP4")


def test_speaker_selects_one_of_several(tmp_path):
    for name in ("anna/a.mp4", "ben/b.mp4", "ben/c.mp4", "d.mp4"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    assert [one.id for one in utterances(corpus(tmp_path, speaker="ben"))] == ["ben-b", "ben-c"]
    assert [one.speaker for one in utterances(corpus(tmp_path))] == ["anna", "ben", "ben", "mine"]
    with pytest.raises(CorpusError, match="speaker 'carl' .* there are recordings without a speaker, anna, ben"):
        utterances(corpus(tmp_path, speaker="carl"))


def test_speaker_names_recordings_that_name_none(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"")
    assert [one.speaker for one in utterances(corpus(tmp_path, speaker="ben"))] == ["ben"]
    assert [one.speaker for one in utterances(corpus(tmp_path))] == ["mine"]
    (tmp_path / "list.csv").write_text("file,transcript,speaker\na.mp4,x,anna\nb.mp4,y,ben\n")
    (one,) = utterances(corpus(tmp_path, table="list.csv", speaker="anna"))
    assert (one.id, one.speaker, one.sound, one.audio, one.motion) == ("a", "anna", str(tmp_path / "a.mp4"), "", "")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_transcripts_in_the_encodings_of_editors(tmp_path, encoding):
    (tmp_path / "a.mp4").write_bytes(b"")
    (tmp_path / "a.txt").write_bytes("naïve café – it’s".encode(encoding))
    assert utterances(corpus(tmp_path))[0].transcript == "naïve café – it’s"


def test_a_table_with_all_columns(tmp_path):
    (tmp_path / "list.tsv").write_text(
        "File\ttranscript\tid\tspeaker\tsplit\temotion\tstart\tend\tnotes\n"
        'v/a.mp4\t"Hi" there\tu1\tanna\ttrain\thappy\t0.5\t2\tx\n'
        "\n"
        "v/b.mp4\tbye\n"
    )
    one, two = utterances(corpus(tmp_path, table="list.tsv"))
    assert (one.id, one.speaker, one.split, one.emotion, one.start, one.end) == (
        "u1",
        "anna",
        "train",
        "happy",
        0.5,
        2.0,
    )
    assert one.transcript == '"Hi" there' and one.media == str(tmp_path / "v/a.mp4")
    assert (two.id, two.speaker, two.split, two.start, two.end) == ("v-b", "v", "", 0.0, 0.0)


@pytest.mark.parametrize("delimiter", [",", ";"])
def test_a_table_of_a_spreadsheet(tmp_path, delimiter):
    row = delimiter.join(["a.mp4", '"yes, it is; really"'])
    (tmp_path / "list.csv").write_text(f"file{delimiter}transcript\n{row}\n", encoding="utf-8-sig")
    assert utterances(corpus(tmp_path, table="list.csv"))[0].transcript == "yes, it is; really"


def test_several_utterances_of_one_recording_get_ids_of_their_own(tmp_path):
    table = tmp_path / "elsewhere.csv"
    table.write_text("file,transcript,start,end\na.mp4,one,0,1\na.mp4,two,1,2\nb.mp4,three,,\n")
    root = tmp_path / "videos"
    root.mkdir()
    found = list_utterances(corpus(root, table=str(table)))
    assert [one.id for one in found] == ["a-0001", "a-0002", "b"]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "no column `file`"),
        ("name,transcript\n", "no column `file` .*name, transcript"),
        ("file,text\n", "no column `transcript`"),
        ("file,transcript,speakr\na.mp4,x,y\n", "`speakr`; if `speaker` is meant"),
        ("file,transcript,transcript\n", "two columns named `transcript`"),
        ("file,transcript\n", "no rows"),
        ("file,transcript\n,hello\n", "line 2: the column `file` is empty"),
        ("file,transcript,start,end\na.mp4,x,2,1\n", "`end` 1 is not after `start` 2"),
        ("file,transcript,start\na.mp4,x,1:30\n", "`start` is '1:30', not a time"),
        ("file,transcript,end\na.mp4,x,nan\n", "`end` is 'nan', not a time"),
        ("file,transcript,split\na.mp4,x,val\n", "split of utterance a is 'val'"),
        ("file,transcript,id\na.mp4,x,a/b\n", "the id 'a/b' cannot be used"),
        ("file,transcript,id\na.mp4,x,u\nb.mp4,y,u\n", "two utterances have one id"),
        ("file,transcript,id\na.mp4,x,U1\nb.mp4,y,u1\n", "two utterances have one id, 'U1' and 'u1'"),
        ("file,transcript,id\na.mp4,x,a/b\n", "list.csv, line 2: the id 'a/b'"),
        (
            f"file,transcript,id\na.mp4,x,u\nb.mp4,x,{'u' * 201}\n",
            "list.csv, line 3: the id u+... has 201 .* at most 200",
        ),
        ("file,transcript,start\na.mp4,x,1e400\n", "line 2: `start` is '1e400', not a time"),
        ("file,transcript,start\na.mp4,x,inf\n", "line 2: `start` is 'inf', not a time"),
        ("file,transcript,start,end\na.mp4,x,2,2\n", "line 2: `end` 2 is not after `start` 2"),
        ("file,transcript\na.mp4,x\n\nb.mp4,well, yes\n", "line 4: the row has 3 cells.*Put a text.*double quotes"),
        ("file\ttranscript\na.mp4\tx\ty\n", "line 2: the row has 3 cells.*a tab separates.*Put a text"),
        (
            'file,transcript\na.mp4,x\nb.mp4,"hello\nc.mp4,bye\n',
            "line 3: .*a quote is not closed.*up to line 4.*Close each quote",
        ),
        ('file,transcript\na.mp4,"hello\nb.mp4,bye\nc.mp4,so"\n', "line 2: .*`transcript` goes on in the next line"),
        ('file,transcript\na.mp4,"hello" there\n', "line 2: .*a text follows a closing quote.*Close each quote"),
        ('file,transcript,id\na.mp4,x,"u\nv"\n', "line 2: .*`id` goes on in the next line"),
        (f"file,transcript\na.mp4,{'x' * 140_000}\n", "line 2: .*a cell has more than 131,072 characters"),
        ("file,transcript\na.mp4,x\nb.mp4,a\0b\n", "line 3: a null character"),
        ("file,transcript\nhttps://host/a.mp4,x\n", "line 2: `file` is the address https://host/a.mp4. Download"),
        ("file,transcript\nfile:/x/a.mp4,x\n", "line 2: `file` is the address"),
        ("file,transcript\nv/,x\n", "line 2: `file` is the folder v/. Name the recording"),
        ("file,transcript\n.,x\n", "line 2: `file` is the folder .\\."),
        ("file,transcript\nv/..,x\n", "line 2: `file` is the folder v/.."),
    ],
)
def test_a_bad_table_is_a_sentence(tmp_path, content, said):
    (tmp_path / "list.csv").write_text(content)
    with pytest.raises(CorpusError, match=f"(?s){said}"):
        list_utterances(corpus(tmp_path, table="list.csv"))


def test_a_table_that_is_missing_or_no_text(tmp_path):
    with pytest.raises(SettingError, match="table none.csv .* does not exist"):
        utterances(corpus(tmp_path, table="none.csv"))
    (tmp_path / "list.csv").write_bytes(b"PK\x03\x04\xff\xfa\x80 a spreadsheet")
    with pytest.raises(CorpusError, match="not UTF-8"):
        utterances(corpus(tmp_path, table="list.csv"))


def test_quotes_are_text_where_tabs_separate(tmp_path):
    (tmp_path / "list.tsv").write_text('file\ttranscript\na.mp4\t"open\nb.mp4\tx\ty\n')
    with pytest.raises(
        CorpusError, match="line 3: the row has 3 cells.*a tab separates cells. Take it out of the text"
    ):
        utterances(corpus(tmp_path, table="list.tsv"))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("table", ["list.csv", "list.tsv"])
def test_rows_end_at_line_ends_alone(tmp_path, end, table):
    tab = "," if table.endswith("csv") else "\t"
    odd = [f"one{character}two" for character in "\u2028\u2029\x0b\x0c\x85\x1c\x1d\x1e"]
    rows = [f"file{tab}transcript", *(f"{number}.mp4{tab}{text}" for number, text in enumerate(odd))]
    (tmp_path / table).write_bytes(end.join(rows).encode())
    found = utterances(corpus(tmp_path, table=table))
    assert [(one.id, one.transcript) for one in found] == [(str(number), "one two") for number in range(len(odd))]


def test_a_quoted_line_break_is_a_space(tmp_path):
    (tmp_path / "list.csv").write_text('file,transcript\na.mp4,"bin blue\nat f, ""two""\r\nnow"\nb.mp4,x\n', newline="")
    found = utterances(corpus(tmp_path, table="list.csv"))
    assert [one.transcript for one in found] == ['bin blue at f, "two" now', "x"]


def test_empty_cells_at_the_end_of_lines_are_left_out(tmp_path):
    (tmp_path / "list.csv").write_text("file,transcript,emotion,,\na.mp4,x,,,\nb.mp4\nc.mp4,z,glad,,,,\n")
    found = utterances(corpus(tmp_path, table="list.csv"))
    assert [(one.transcript, one.emotion) for one in found] == [("x", ""), ("", ""), ("z", "glad")]


def test_an_absolute_path_and_one_outside_the_root_are_taken_as_they_are(tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    (root / "list.csv").write_text(f"file,transcript,id\n{tmp_path}/else/a.mp4,x,a\n../else/b.mp4,y,b\n")
    one, two = utterances(corpus(root, table="list.csv"))
    assert (one.media, one.speaker) == (f"{tmp_path}/else/a.mp4", "else")
    assert two.media == f"{root}/../else/b.mp4"


def test_equal_rows_are_two_utterances_for_the_check(tmp_path):
    (tmp_path / "list.csv").write_text("file,transcript\na.mp4,x\n\na.mp4,x\n")
    assert [one.id for one in utterances(corpus(tmp_path, table="list.csv"))] == ["a-0001", "a-0002"]


def test_a_table_in_utf_16_is_read(tmp_path):
    (tmp_path / "list.tsv").write_bytes("file\ttranscript\na.mp4\tnaïve\n".encode("utf-16"))
    assert utterances(corpus(tmp_path, table="list.tsv"))[0].transcript == "naïve"


@pytest.mark.parametrize("root", ["~nobodyhere/x", "a" * 300, "nul\0character", "x/" * 400])
def test_a_root_that_cannot_be_is_a_sentence(root):
    with pytest.raises(SettingError, match="the root of the corpus 'mine' does not exist"):
        utterances(corpus(root))

# Input blocks of dynamic visemes.
def viseme_blocks(system):
    """Names of the blocks of dynamic visemes that rows of a system read, or that those blocks are made of."""
    blocks = SETTINGS["systems"][system]["blocks"]
    read = blocks_read(system)
    read += [blocks[name]["settings"][key] for name in read for key in parts_of(block_class(blocks[name]["kind"]))]
    return [name for name in dict.fromkeys(read) if blocks[name]["kind"] == "dynamic_visemes"]


def drawn_visemes(wildcards):
    """Input function: pictures of the classes of visemes of a system, one for each different set of classes."""
    if not is_pictured(wildcards.system):
        return []
    blocks, found = system_of(wildcards)["blocks"], {}
    for name in viseme_blocks(wildcards.system):
        settings = {key: value for key, value in blocks[name]["settings"].items() if key not in ("source", "folds")}
        found.setdefault(digest(settings), name)
    return filled("<system>/features/{block}/visemes.png", wildcards, block=list(found.values()))


def numbered_block(system):
    """Name of the block whose number of classes the target viseme_numbers varies; None for a system without visemes."""
    own = SETTINGS["systems"][system]
    named = [name for name, block in own["blocks"].items() if block["kind"] == "dynamic_visemes"]
    return own["viseme_numbers"]["block"] or next(iter(named), None)


def viseme_number_tables(wildcards):
    """Input function: the tables of the target viseme_numbers."""
    pattern = plain("<system>/tables/viseme_numbers.tsv")
    found = [pattern.format(corpus=corpus, system=system) for corpus, system in PLAN.pairs if numbered_block(system)]
    if not found:
        refuse("no selected system has an input block of kind dynamic_visemes; select one that has.")
    return found

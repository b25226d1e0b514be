#include "ensemble/study/yaml.h"

#include "ensemble/input/slurp.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

/* A map or list that is still open while the events come in. */
struct open_node {
    size_t node;
    size_t last; /* its latest child, 0 for none */
};

struct builder {
    struct rk_yaml *tree;
    struct rk_error *err;
    struct open_node open[RK_YAML_DEPTH];
    size_t depth;
    char *key; /* read, its value still to come */
    struct rk_yaml_place key_place;
    bool complete;
};

enum rk_status rk_yaml_wrong(const struct rk_yaml *tree, struct rk_yaml_place place,
                             struct rk_error *err, const char *format, ...) {
    char message[sizeof err->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    rk_fail(err, RK_EINVALID, "%s", message);
    rk_yaml_locate(tree, place, err);
    return RK_EINVALID;
}

void rk_yaml_locate(const struct rk_yaml *tree, struct rk_yaml_place place, struct rk_error *err) {
    rk_error_locate(err, "%s:%zu:%zu", tree->name, place.line, place.column);
}

const char *rk_yaml_kind_name(enum rk_yaml_kind kind) {
    static const char *const names[] = {"a single value", "a map", "a list"};
    return names[kind];
}

static struct rk_yaml_place place_of(yaml_mark_t mark) {
    return (struct rk_yaml_place){mark.line + 1, mark.column + 1};
}

static bool is_map(const struct builder *b) {
    return b->depth > 0 && b->tree->nodes[b->open[b->depth - 1].node].kind == RK_YAML_MAP;
}

/* A new node below the innermost open one; its index in *index. */
static enum rk_status add_node(struct builder *b, enum rk_yaml_kind kind,
                               struct rk_yaml_place place, size_t *index) {
    struct rk_yaml *tree = b->tree;
    if (tree->count == RK_YAML_NODES) {
        return rk_yaml_wrong(tree, place, b->err, "more than %zu values in one file",
                             RK_YAML_NODES);
    }
    if (tree->count == tree->room) {
        size_t room = tree->room ? 2 * tree->room : 64;
        struct rk_yaml_node *nodes = realloc(tree->nodes, room * sizeof *nodes);
        if (!nodes) {
            return rk_fail(b->err, RK_EMEMORY, "out of memory");
        }
        tree->nodes = nodes;
        tree->room = room;
    }
    *index = tree->count++;
    tree->nodes[*index] = (struct rk_yaml_node){
        .kind = kind, .place = place, .key = b->key, .key_place = b->key_place};
    b->key = NULL;
    if (b->depth > 0) {
        struct open_node *parent = &b->open[b->depth - 1];
        if (parent->last) {
            tree->nodes[parent->last].next = *index;
        } else {
            tree->nodes[parent->node].first = *index;
        }
        parent->last = *index;
        tree->nodes[parent->node].count++;
    }
    return RK_OK;
}

static enum rk_status check_key(struct builder *b, const char *key, struct rk_yaml_place place) {
    const struct rk_yaml_node *map = &b->tree->nodes[b->open[b->depth - 1].node];
    if (key[0] == '\0') {
        return rk_yaml_wrong(b->tree, place, b->err, "a key is empty");
    }
    /* Also bounds the search for duplicates, which looks at all keys before this one. */
    if (map->count == RK_YAML_KEYS) {
        return rk_yaml_wrong(b->tree, place, b->err, "more than %d keys in one map", RK_YAML_KEYS);
    }
    const struct rk_yaml_node *other = rk_yaml_member(b->tree, map, key);
    if (other) {
        return rk_yaml_wrong(b->tree, place, b->err, "'%.64s' is given twice, first in line %zu",
                             key, other->key_place.line);
    }
    return RK_OK;
}

static enum rk_status add_scalar(struct builder *b, const yaml_event_t *event) {
    struct rk_yaml_place place = place_of(event->start_mark);
    const char *value = (const char *)event->data.scalar.value;
    if (memchr(value, '\0', event->data.scalar.length)) {
        return rk_yaml_wrong(b->tree, place, b->err, "a text holds a NUL character");
    }
    bool key = is_map(b) && !b->key;
    if (key) {
        enum rk_status status = check_key(b, value, place);
        if (status != RK_OK) {
            return status;
        }
    }
    char *text = strdup(value);
    if (!text) {
        return rk_fail(b->err, RK_EMEMORY, "out of memory");
    }
    if (key) {
        b->key = text;
        b->key_place = place;
        return RK_OK;
    }
    size_t index = 0;
    enum rk_status status = add_node(b, RK_YAML_TEXT, place, &index);
    if (status != RK_OK) {
        free(text);
        return status;
    }
    b->tree->nodes[index].text = text;
    return RK_OK;
}

static enum rk_status open_container(struct builder *b, enum rk_yaml_kind kind,
                                     const yaml_event_t *event) {
    struct rk_yaml_place place = place_of(event->start_mark);
    if (is_map(b) && !b->key) {
        return rk_yaml_wrong(b->tree, place, b->err, "%s cannot be a key", rk_yaml_kind_name(kind));
    }
    if (b->depth == RK_YAML_DEPTH) {
        return rk_yaml_wrong(b->tree, place, b->err, "nested more than %d deep", RK_YAML_DEPTH);
    }
    size_t index = 0;
    enum rk_status status = add_node(b, kind, place, &index);
    if (status == RK_OK) {
        b->open[b->depth++] = (struct open_node){.node = index};
    }
    return status;
}

/* Anchors make one text stand for another, tags change what it means: both are refused. */
static enum rk_status check_plain(struct builder *b, const yaml_event_t *event) {
    const unsigned char *anchor = NULL, *tag = NULL;
    if (event->type == YAML_SCALAR_EVENT) {
        anchor = event->data.scalar.anchor;
        tag = event->data.scalar.tag;
    } else if (event->type == YAML_MAPPING_START_EVENT) {
        anchor = event->data.mapping_start.anchor;
        tag = event->data.mapping_start.tag;
    } else if (event->type == YAML_SEQUENCE_START_EVENT) {
        anchor = event->data.sequence_start.anchor;
        tag = event->data.sequence_start.tag;
    }
    if (anchor || event->type == YAML_ALIAS_EVENT) {
        return rk_yaml_wrong(b->tree, place_of(event->start_mark), b->err,
                             "anchors and aliases (& and *) are not supported; write it out");
    }
    if (tag) {
        return rk_yaml_wrong(b->tree, place_of(event->start_mark), b->err,
                             "tags (!) are not supported");
    }
    return RK_OK;
}

static enum rk_status take(struct builder *b, const yaml_event_t *event) {
    enum rk_status status = check_plain(b, event);
    if (status != RK_OK) {
        return status;
    }
    switch (event->type) {
    case YAML_DOCUMENT_START_EVENT:
        if (b->tree->count > 0) {
            return rk_yaml_wrong(b->tree, place_of(event->start_mark), b->err,
                                 "a second document begins here; one is expected");
        }
        return RK_OK;
    case YAML_SCALAR_EVENT:
        return add_scalar(b, event);
    case YAML_MAPPING_START_EVENT:
        return open_container(b, RK_YAML_MAP, event);
    case YAML_SEQUENCE_START_EVENT:
        return open_container(b, RK_YAML_LIST, event);
    case YAML_MAPPING_END_EVENT:
    case YAML_SEQUENCE_END_EVENT:
        b->depth--;
        return RK_OK;
    case YAML_STREAM_END_EVENT:
        b->complete = true;
        return RK_OK;
    default:
        return RK_OK;
    }
}

/* The reader's errors (bad UTF-8) know an offset in bytes only. */
static struct rk_yaml_place place_at(const unsigned char *bytes, size_t size, size_t offset) {
    struct rk_yaml_place place = {1, 1};
    for (size_t i = 0; i < offset && i < size; i++) {
        place.column++;
        if (bytes[i] == '\n') {
            place.line++;
            place.column = 1;
        }
    }
    return place;
}

/* Is there a tab among the blanks that the line begins with? */
static bool is_tabbed(const unsigned char *bytes, size_t size, size_t line) {
    size_t i = 0;
    for (size_t at = 1; at < line && i < size; i++) {
        at += bytes[i] == '\n';
    }
    while (i < size && bytes[i] == ' ') {
        i++;
    }
    return i < size && bytes[i] == '\t';
}

static enum rk_status syntax_error(struct builder *b, const yaml_parser_t *parser,
                                   const unsigned char *bytes, size_t size) {
    const char *problem = parser->problem ? parser->problem : "unknown problem";
    if (parser->error == YAML_MEMORY_ERROR) {
        return rk_fail(b->err, RK_EMEMORY, "out of memory");
    }
    if (parser->error == YAML_READER_ERROR) {
        return rk_yaml_wrong(b->tree, place_at(bytes, size, parser->problem_offset), b->err,
                             "not a UTF-8 text: %s", problem);
    }
    struct rk_yaml_place place = place_of(parser->problem_mark);
    if (is_tabbed(bytes, size, place.line)) {
        return rk_yaml_wrong(b->tree, place, b->err,
                             "the line begins with a tab; YAML is indented with blanks only");
    }
    return rk_yaml_wrong(b->tree, place, b->err, "not valid YAML: %s%s%s",
                         parser->context ? parser->context : "", parser->context ? ", " : "",
                         problem);
}

static enum rk_status build(struct builder *b, const unsigned char *bytes, size_t size) {
    yaml_parser_t parser;
    /* libyaml takes a byte order mark for text once it is told the encoding. */
    if (size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0) {
        bytes += 3;
        size -= 3;
    }
    if (!yaml_parser_initialize(&parser)) {
        return rk_fail(b->err, RK_EMEMORY, "out of memory");
    }
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, bytes, size);
    enum rk_status status = RK_OK;
    while (status == RK_OK && !b->complete) {
        yaml_event_t event;
        if (!yaml_parser_parse(&parser, &event)) {
            status = syntax_error(b, &parser, bytes, size);
            break;
        }
        status = take(b, &event);
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    free(b->key);
    if (status == RK_OK && b->tree->count == 0) {
        status = rk_yaml_wrong(b->tree, (struct rk_yaml_place){1, 1}, b->err, "the file is empty");
    }
    return status;
}

enum rk_status rk_yaml_parse(const char *name, const void *bytes, size_t size,
                             struct rk_yaml **tree, struct rk_error *err) {
    struct builder b = {.tree = calloc(1, sizeof *b.tree), .err = err};
    *tree = NULL;
    if (b.tree) {
        b.tree->name = strdup(name);
    }
    if (!b.tree || !b.tree->name) {
        rk_yaml_free(b.tree);
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = build(&b, bytes, size);
    if (status == RK_OK) {
        *tree = b.tree;
    } else {
        rk_yaml_free(b.tree);
    }
    return status;
}

enum rk_status rk_yaml_load(const char *path, struct rk_yaml **tree, struct rk_error *err) {
    char *bytes;
    size_t size;
    *tree = NULL;
    enum rk_status status = rk_slurp(path, RK_YAML_BYTES, &bytes, &size, err);
    if (status == RK_OK) {
        status = rk_yaml_parse(path, bytes, size, tree, err);
        free(bytes);
    }
    return status;
}

void rk_yaml_free(struct rk_yaml *tree) {
    if (!tree) {
        return;
    }
    for (size_t i = 0; i < tree->count; i++) {
        free(tree->nodes[i].text);
        free(tree->nodes[i].key);
    }
    free(tree->nodes);
    free(tree->name);
    free(tree);
}

const struct rk_yaml_node *rk_yaml_root(const struct rk_yaml *tree) {
    return &tree->nodes[0];
}

const struct rk_yaml_node *rk_yaml_first(const struct rk_yaml *tree,
                                         const struct rk_yaml_node *node) {
    return node->first ? &tree->nodes[node->first] : NULL;
}

const struct rk_yaml_node *rk_yaml_next(const struct rk_yaml *tree,
                                        const struct rk_yaml_node *node) {
    return node->next ? &tree->nodes[node->next] : NULL;
}

const struct rk_yaml_node *rk_yaml_member(const struct rk_yaml *tree,
                                          const struct rk_yaml_node *map, const char *key) {
    for (const struct rk_yaml_node *n = rk_yaml_first(tree, map); n; n = rk_yaml_next(tree, n)) {
        if (strcmp(n->key, key) == 0) {
            return n;
        }
    }
    return NULL;
}
